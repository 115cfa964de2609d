#include <IpIpoptApplication.hpp>
#include <IpTNLP.hpp>
#include <algorithm>
#include <mutex>

#include "excitation/search/nonlinear_program.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using Ipopt::Index;
using Ipopt::Number;

constexpr double kInfinity = 2e19;  // what Ipopt takes for no bound

// The sparse solver behind Ipopt keeps state that threads share. Whoever runs Ipopt's own code
// holds this; while the functions of a program run, others may.
std::mutex& baton() {
  static std::mutex one;
  return one;
}

// Gives the baton away for the time of a call.
class Away {
 public:
  Away() { baton().unlock(); }
  ~Away() { baton().lock(); }
  Away(const Away&) = delete;
  Away& operator=(const Away&) = delete;
};

class Adapter final : public Ipopt::TNLP {
 public:
  Adapter(NonlinearProgram& program, VectorXd start, const SolverOptions& options)
      : x(std::move(start)), program_(program), options_(options) {}

  bool get_nlp_info(Index& n, Index& m, Index& nonzeros, Index& hessian_nonzeros,
                    IndexStyleEnum& style) override {
    n = program_.variables();
    m = static_cast<Index>(program_.lower().size());
    nonzeros = static_cast<Index>(program_.pattern().size());
    hessian_nonzeros = 0;
    style = C_STYLE;
    return true;
  }

  bool get_bounds_info(Index n, Number* x_low, Number* x_up, Index m, Number* low,
                       Number* up) override {
    std::fill(x_low, x_low + n, -kInfinity);
    std::fill(x_up, x_up + n, kInfinity);
    for (Index k = 0; k < m; ++k) {
      low[k] = std::max(-kInfinity, program_.lower()[k]);
      up[k] = std::min(kInfinity, program_.upper()[k]);
    }
    return true;
  }

  bool get_starting_point(Index n, bool, Number* to, bool, Number*, Number*, Index, bool,
                          Number*) override {
    std::copy(x.data(), x.data() + n, to);
    return true;
  }

  bool eval_f(Index n, const Number* at, bool, Number& value) override {
    const Away away;
    value = program_.objective(Eigen::Map<const VectorXd>(at, n));
    return true;
  }

  bool eval_grad_f(Index n, const Number* at, bool, Number* to) override {
    const Away away;
    Eigen::Map<VectorXd>(to, n) = program_.gradient(Eigen::Map<const VectorXd>(at, n));
    return true;
  }

  bool eval_g(Index n, const Number* at, bool, Index m, Number* to) override {
    const Away away;
    Eigen::Map<VectorXd>(to, m) = program_.constraints(Eigen::Map<const VectorXd>(at, n));
    return true;
  }

  bool eval_jac_g(Index n, const Number* at, bool, Index, Index count, Index* rows, Index* columns,
                  Number* to) override {
    if (to == nullptr) {
      for (Index k = 0; k < count; ++k) {
        rows[k] = program_.pattern()[static_cast<size_t>(k)].first;
        columns[k] = program_.pattern()[static_cast<size_t>(k)].second;
      }
      return true;
    }
    const Away away;
    Eigen::Map<VectorXd>(to, count) = program_.jacobian(Eigen::Map<const VectorXd>(at, n));
    return true;
  }

  bool intermediate_callback(Ipopt::AlgorithmMode, Index iteration, Number, Number, Number, Number,
                             Number, Number, Number, Number, Index, const Ipopt::IpoptData*,
                             Ipopt::IpoptCalculatedQuantities*) override {
    iterations = iteration;
    const Away away;
    return !options_.stop || !options_.stop();
  }

  void finalize_solution(Ipopt::SolverReturn, Index n, const Number* at, const Number*,
                         const Number*, Index, const Number*, const Number*, Number,
                         const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {
    x = Eigen::Map<const VectorXd>(at, n);
  }

  VectorXd x;
  int iterations = 0;

 private:
  NonlinearProgram& program_;
  const SolverOptions& options_;
};

}  // namespace

SolverResult solve_with_ipopt(NonlinearProgram& program, const VectorXd& start,
                              const SolverOptions& options) {
  const std::lock_guard<std::mutex> turn(baton());
  const Ipopt::SmartPtr<Ipopt::IpoptApplication> solver = new Ipopt::IpoptApplication(false);
  solver->Options()->SetStringValue("hessian_approximation", "limited-memory");
  // A longer history saves iterations and costs solves of the sparse solver; scaling of the matrix
  // costs more than it brings, since the limits are scaled already.
  solver->Options()->SetIntegerValue("limited_memory_max_history", 12);
  solver->Options()->SetIntegerValue("mumps_scaling", 0);
  solver->Options()->SetStringValue("linear_solver", "mumps");
  solver->Options()->SetStringValue("mu_strategy", "adaptive");
  solver->Options()->SetStringValue("sb", "yes");
  solver->Options()->SetIntegerValue("print_level", 0);
  solver->Options()->SetIntegerValue("max_iter", options.iterations);
  solver->Options()->SetNumericValue("tol", options.tolerance);
  solver->Options()->SetNumericValue("constr_viol_tol", 1e-6);
  solver->Options()->SetNumericValue("acceptable_tol", 10.0 * options.tolerance);
  solver->Options()->SetIntegerValue("acceptable_iter", 8);
  solver->Options()->SetNumericValue("acceptable_obj_change_tol", 1e-4);
  const Ipopt::SmartPtr<Adapter> adapter = new Adapter(program, start, options);
  require(solver->Initialize() == Ipopt::Solve_Succeeded, "Ipopt: it could not be started.");
  const Ipopt::ApplicationReturnStatus status = solver->OptimizeTNLP(GetRawPtr(adapter));
  return {adapter->x,
          status == Ipopt::Solve_Succeeded || status == Ipopt::Solved_To_Acceptable_Level,
          adapter->iterations};
}

}  // namespace veridyn
