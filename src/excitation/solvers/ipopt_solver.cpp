#define HAVE_CSTDDEF  // required by Debian's Ipopt 3.11
#include <IpIpoptApplication.hpp>
#include <IpTNLP.hpp>

#include <algorithm>
#include <mutex>
#include <utility>

#include "excitation/solvers/nonlinear_program.hpp"
#include "excitation/solvers/working_set.hpp"

namespace veridyn {
namespace {

using Ipopt::Index;
using Ipopt::Number;

constexpr double kUnbounded = 2e19;       // Ipopt's infinity
constexpr double kLimitTolerance = 1e-6;  // tolerance as a share of a limit's scale
constexpr double kFirstStep = 0.1;        // length of the first step, before the curvature is known
constexpr int kPatience = 8;              // iterations that change the objective by less than kSmallestGain
constexpr double kSmallestGain = 1e-4;

// A program in Ipopt's interface. Variables and limits are scaled. The Hessian of the Lagrangian is
// a dense BFGS matrix, updated at every point: motions have tens of variables, and a limited-memory
// update would lose curvature of the criterion.
class IpoptProgram final : public Ipopt::TNLP {
 public:
  IpoptProgram(NonlinearProgram& program, VectorXd start, const SolverOptions& options)
      : result{std::move(start)}, program_(program), options_(options) {}

  bool get_nlp_info(Index& n, Index& m, Index& nonzeros, Index& hessian_nonzeros,
                    IndexStyleEnum& style) override {
    n = program_.variables();
    m = static_cast<Index>(program_.lower().size());
    nonzeros = static_cast<Index>(program_.pattern().size());
    hessian_nonzeros = n * (n + 1) / 2;
    style = C_STYLE;
    return true;
  }
  bool get_bounds_info(Index n, Number* x_low, Number* x_up, Index m, Number* low, Number* up) override {
    std::fill(x_low, x_low + n, -kUnbounded);
    std::fill(x_up, x_up + n, kUnbounded);
    for (Index k = 0; k < m; ++k) {
      low[k] = std::max(-kUnbounded, program_.lower()[k]);
      up[k] = std::min(kUnbounded, program_.upper()[k]);
    }
    return true;
  }
  bool get_starting_point(Index n, bool, Number* to, bool, Number*, Number*, Index, bool, Number*) override {
    std::copy(result.x.data(), result.x.data() + n, to);
    return true;
  }
  bool eval_f(Index n, const Number* at, bool, Number& value) override {
    value = program_.objective(Eigen::Map<const VectorXd>(at, n));
    return true;
  }
  bool eval_grad_f(Index n, const Number* at, bool, Number* to) override {
    Eigen::Map<VectorXd>(to, n) = program_.gradient(Eigen::Map<const VectorXd>(at, n));
    return true;
  }
  bool eval_g(Index n, const Number* at, bool, Index m, Number* to) override {
    Eigen::Map<VectorXd>(to, m) = program_.constraints(Eigen::Map<const VectorXd>(at, n));
    return true;
  }
  bool eval_jac_g(Index n, const Number* at, bool, Index, Index count, Index* rows, Index* columns,
                  Number* to) override {
    if (to != nullptr) {
      Eigen::Map<VectorXd>(to, count) = program_.jacobian(Eigen::Map<const VectorXd>(at, n));
      return true;
    }
    for (Index k = 0; k < count; ++k) {
      rows[k] = program_.pattern()[k].first;
      columns[k] = program_.pattern()[k].second;
    }
    return true;
  }
  bool eval_h(Index n, const Number* at, bool, Number, Index m, const Number* multipliers, bool, Index,
              Index* rows, Index* columns, Number* to) override {
    if (to != nullptr) update(Eigen::Map<const VectorXd>(at, n), Eigen::Map<const VectorXd>(multipliers, m));
    for (Index row = 0, k = 0; row < n; ++row) {
      for (Index column = 0; column <= row; ++column, ++k) {
        if (to != nullptr) {
          to[k] = B_(row, column);
        } else {
          rows[k] = row;
          columns[k] = column;
        }
      }
    }
    return true;
  }
  bool intermediate_callback(Ipopt::AlgorithmMode, Index iteration, Number, Number, Number, Number, Number,
                             Number, Number, Number, Index, const Ipopt::IpoptData*,
                             Ipopt::IpoptCalculatedQuantities*) override {
    result.iterations = iteration;
    return !options_.stop || !options_.stop();
  }
  void finalize_solution(Ipopt::SolverReturn, Index n, const Number* at, const Number*, const Number*, Index,
                         const Number*, const Number*, Number, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {
    result.x = Eigen::Map<const VectorXd>(at, n);
  }

  SolverResult result;

 private:
  // Gradient of the Lagrangian, f + multipliers' c.
  VectorXd lagrangian(const VectorXd& gradient, const VectorXd& jacobian, const VectorXd& multipliers) const {
    VectorXd out = gradient;
    for (Eigen::Index e = 0; e < jacobian.size(); ++e) {
      const auto [row, column] = program_.pattern()[e];
      out[column] += multipliers[row] * jacobian[e];
    }
    return out;
  }

  void update(const VectorXd& x, const VectorXd& multipliers) {
    const VectorXd gradient = program_.gradient(x);
    const VectorXd jacobian = program_.jacobian(x);
    if (B_.size() == 0) {
      B_ = MatrixXd::Identity(x.size(), x.size()) * std::max(kLimitTolerance, gradient.norm() / kFirstStep);
    } else if (x != x_) {
      update_hessian(B_, x - x_,
                     lagrangian(gradient, jacobian, multipliers) - lagrangian(gradient_, jacobian_, multipliers),
                     first_);
      first_ = false;
    }
    x_ = x;
    gradient_ = gradient;
    jacobian_ = jacobian;
  }

  NonlinearProgram& program_;
  const SolverOptions& options_;
  MatrixXd B_;
  VectorXd x_, gradient_, jacobian_;  // values at the last update
  bool first_ = true;
};

SolverResult ipopt(NonlinearProgram& program, const VectorXd& start, const SolverOptions& options) {
  static std::mutex one_at_a_time;  // MUMPS has global state
  const std::lock_guard<std::mutex> lock(one_at_a_time);
  const Ipopt::SmartPtr<Ipopt::IpoptApplication> solver = new Ipopt::IpoptApplication(false);
  const auto set = solver->Options();
  set->SetStringValue("linear_solver", "mumps");
  set->SetIntegerValue("mumps_scaling", 0);
  set->SetStringValue("nlp_scaling_method", "none");
  set->SetStringValue("mu_strategy", "adaptive");
  set->SetStringValue("sb", "yes");
  set->SetIntegerValue("print_level", 0);
  set->SetIntegerValue("max_iter", options.iterations);
  set->SetNumericValue("tol", options.tolerance);
  set->SetNumericValue("constr_viol_tol", kLimitTolerance);
  set->SetNumericValue("acceptable_tol", 10.0 * options.tolerance);
  set->SetIntegerValue("acceptable_iter", kPatience);
  set->SetNumericValue("acceptable_obj_change_tol", kSmallestGain);
  const Ipopt::SmartPtr<IpoptProgram> asked = new IpoptProgram(program, start, options);
  solver->Initialize();
  const Ipopt::ApplicationReturnStatus status = solver->OptimizeTNLP(GetRawPtr(asked));
  asked->result.converged =
      status == Ipopt::Solve_Succeeded || status == Ipopt::Solved_To_Acceptable_Level;
  return asked->result;
}

}  // namespace

SolverResult solve_with_ipopt(NonlinearProgram& program, const VectorXd& start, const SolverOptions& options) {
  return with_working_set(ipopt, program, start, options);
}

}  // namespace veridyn
