// What earns the interior point of src/excitation its place: criterion and processor seconds beside
// NLopt's SLSQP and Ipopt, which get the same searches (trial descents, starts, exact gradients) and
// only those limits that can become active. On one core; see docs/excitation.md for the table.
//
//   veridyn-excitation-solvers [SEEDS [SOLVER...]]

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "benchmark/working_set.hpp"
#include "excitation/search/motion_search.hpp"
#include "veridyn/model/model_file.hpp"

#ifdef VERIDYN_COMPARED_WITH_NLOPT
#include <nlopt.h>
#endif
#ifdef VERIDYN_COMPARED_WITH_IPOPT
#include <IpIpoptApplication.hpp>
#include <IpTNLP.hpp>
#endif

namespace veridyn {
namespace {

#ifdef VERIDYN_COMPARED_WITH_NLOPT
struct Problem {
  NonlinearProgram& program;
  const SolverOptions& options;
  nlopt_opt solver;
  std::vector<std::pair<int, double>> rows;  // and +1 for an upper bound, -1 for a lower one
};

double objective(unsigned n, const double* at, double* gradient, void* data) {
  auto& p = *static_cast<Problem*>(data);
  if (p.options.stop && p.options.stop()) nlopt_force_stop(p.solver);
  const VectorXd x = Eigen::Map<const VectorXd>(at, n);
  const double value = p.program.objective(x);
  if (gradient != nullptr) Eigen::Map<VectorXd>(gradient, n) = p.program.gradient(x);
  return value;
}

void constraints(unsigned m, double* result, unsigned n, const double* at, double* gradient,
                 void* data) {
  auto& p = *static_cast<Problem*>(data);
  const VectorXd x = Eigen::Map<const VectorXd>(at, n);
  const VectorXd c = p.program.constraints(x);
  for (unsigned k = 0; k < m; ++k) {
    const auto [row, sign] = p.rows[k];
    result[k] = sign * (c[row] - (sign > 0.0 ? p.program.upper()[row] : p.program.lower()[row]));
  }
  if (gradient == nullptr) return;
  MatrixXd J = MatrixXd::Zero(c.size(), n);
  const VectorXd values = p.program.jacobian(x);
  for (size_t e = 0; e < p.program.pattern().size(); ++e)
    J(p.program.pattern()[e].first, p.program.pattern()[e].second) =
        values[static_cast<Eigen::Index>(e)];
  for (unsigned k = 0; k < m; ++k)
    Eigen::Map<VectorXd>(gradient + static_cast<size_t>(k) * n, n) =
        p.rows[k].second * J.row(p.rows[k].first).transpose();
}

// Sequential quadratic programming with a dense BFGS matrix (Kraft 1988), as NLopt has it.
SolverResult slsqp(NonlinearProgram& program, const VectorXd& start, const SolverOptions& options) {
  const auto n = static_cast<unsigned>(program.variables());
  const std::unique_ptr<std::remove_pointer_t<nlopt_opt>, void (*)(nlopt_opt)> solver(
      nlopt_create(NLOPT_LD_SLSQP, n), nlopt_destroy);
  Problem problem{program, options, solver.get(), {}};
  for (int i = 0; i < program.lower().size(); ++i) {
    if (std::isfinite(program.upper()[i])) problem.rows.emplace_back(i, 1.0);
    if (std::isfinite(program.lower()[i])) problem.rows.emplace_back(i, -1.0);
  }
  nlopt_set_min_objective(solver.get(), objective, &problem);
  const auto rows = static_cast<unsigned>(problem.rows.size());
  const VectorXd tolerances = VectorXd::Constant(rows, 1e-7);
  if (rows > 0)
    nlopt_add_inequality_mconstraint(solver.get(), rows, constraints, &problem, tolerances.data());
  nlopt_set_maxeval(solver.get(), options.iterations);
  nlopt_set_ftol_rel(solver.get(), 1e-5);
  SolverResult out{start};
  double value = 0.0;
  const nlopt_result status = nlopt_optimize(solver.get(), out.x.data(), &value);
  out.converged = status > 0 && status != NLOPT_MAXEVAL_REACHED;
  out.iterations = nlopt_get_numevals(solver.get());
  return out;
}
#endif

#ifdef VERIDYN_COMPARED_WITH_IPOPT
using Ipopt::Index;
using Ipopt::Number;

class Adapter final : public Ipopt::TNLP {
 public:
  Adapter(NonlinearProgram& program, VectorXd start, const SolverOptions& options)
      : result{std::move(start)}, program_(program), options_(options) {}

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
    constexpr double kNone = 2e19;
    std::fill(x_low, x_low + n, -kNone);
    std::fill(x_up, x_up + n, kNone);
    for (Index k = 0; k < m; ++k) {
      low[k] = std::max(-kNone, program_.lower()[k]);
      up[k] = std::min(kNone, program_.upper()[k]);
    }
    return true;
  }
  bool get_starting_point(Index n, bool, Number* to, bool, Number*, Number*, Index, bool,
                          Number*) override {
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
      rows[k] = program_.pattern()[static_cast<size_t>(k)].first;
      columns[k] = program_.pattern()[static_cast<size_t>(k)].second;
    }
    return true;
  }
  bool intermediate_callback(Ipopt::AlgorithmMode, Index iteration, Number, Number, Number, Number,
                             Number, Number, Number, Number, Index, const Ipopt::IpoptData*,
                             Ipopt::IpoptCalculatedQuantities*) override {
    result.iterations = iteration;
    return !options_.stop || !options_.stop();
  }
  void finalize_solution(Ipopt::SolverReturn, Index n, const Number* at, const Number*,
                         const Number*, Index, const Number*, const Number*, Number,
                         const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {
    result.x = Eigen::Map<const VectorXd>(at, n);
  }

  SolverResult result;

 private:
  NonlinearProgram& program_;
  const SolverOptions& options_;
};

// Interior point with a filter and an L-BFGS Hessian (Waechter and Biegler, Mathematical
// Programming 106(1), 2006).
SolverResult ipopt(NonlinearProgram& program, const VectorXd& start, const SolverOptions& options) {
  const Ipopt::SmartPtr<Ipopt::IpoptApplication> solver = new Ipopt::IpoptApplication(false);
  const auto set = solver->Options();
  set->SetStringValue("hessian_approximation", "limited-memory");
  set->SetIntegerValue("limited_memory_max_history", 12);
  set->SetIntegerValue("mumps_scaling", 0);
  set->SetStringValue("linear_solver", "mumps");
  set->SetStringValue("mu_strategy", "adaptive");
  set->SetStringValue("sb", "yes");
  set->SetIntegerValue("print_level", 0);
  set->SetIntegerValue("max_iter", options.iterations);
  set->SetNumericValue("tol", options.tolerance);
  set->SetNumericValue("constr_viol_tol", 1e-6);
  set->SetNumericValue("acceptable_tol", 10.0 * options.tolerance);
  set->SetIntegerValue("acceptable_iter", 8);
  set->SetNumericValue("acceptable_obj_change_tol", 1e-4);
  const Ipopt::SmartPtr<Adapter> adapter = new Adapter(program, start, options);
  solver->Initialize();
  const Ipopt::ApplicationReturnStatus status = solver->OptimizeTNLP(GetRawPtr(adapter));
  adapter->result.converged =
      status == Ipopt::Solve_Succeeded || status == Ipopt::Solved_To_Acceptable_Level;
  return adapter->result;
}
#endif

struct Rival {
  std::string name;
  NonlinearSolver solver;
};

[[maybe_unused]] NonlinearSolver limited(const NonlinearSolver& solver) {
  return [solver](NonlinearProgram& program, const VectorXd& start, const SolverOptions& options) {
    return with_working_set(solver, program, start, options);
  };
}

std::vector<Rival> rivals() {
  std::vector<Rival> out{{"interior-point", solve_with_interior_point}};
#ifdef VERIDYN_COMPARED_WITH_NLOPT
  out.push_back({"slsqp", limited(slsqp)});
#endif
#ifdef VERIDYN_COMPARED_WITH_IPOPT
  out.push_back({"ipopt", limited(ipopt)});
#endif
  return out;
}

double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec);
}

void compare(const std::string& robot, ExcitationCriterion criterion, int seeds,
             const std::vector<Rival>& solvers) {
  const Model arm = read_model(robot);
  for (const Rival& rival : solvers) {
    std::vector<double> values, seconds;
    for (int seed = 1; seed <= seeds; ++seed) {
      ExcitationOptions options;
      options.criterion = criterion;
      options.threads = 1;
      options.seed = static_cast<unsigned>(seed);
      const double begun = processor_seconds();
      const Excitation e = optimise_excitation(arm, options, rival.solver);
      seconds.push_back(processor_seconds() - begun);
      values.push_back(criterion == ExcitationCriterion::kCondition ? e.condition_number
                                                                    : e.log_determinant);
    }
    std::sort(values.begin(), values.end());
    std::sort(seconds.begin(), seconds.end());
    const auto middle = static_cast<size_t>(seeds / 2);
    std::printf("| %s | %s | %s | %.4g | %.4g to %.4g | %.2f |\n", robot.c_str(),
                name_of(criterion), rival.name.c_str(), values[middle], values.front(),
                values.back(), seconds[middle]);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace veridyn

int main(int count, char** words) {
  using namespace veridyn;
  const int seeds = count > 1 ? std::max(1, std::atoi(words[1])) : 5;
  std::vector<Rival> solvers = rivals();
  if (count > 2) {
    const std::vector<std::string> wanted(words + 2, words + count);
    solvers.erase(std::remove_if(solvers.begin(), solvers.end(),
                                 [&](const Rival& r) {
                                   return std::find(wanted.begin(), wanted.end(), r.name) ==
                                          wanted.end();
                                 }),
                  solvers.end());
  }
  std::printf("| arm | criterion | solver | median | range | processor seconds |\n");
  std::printf("|---|---|---|---|---|---|\n");
  for (const auto criterion : {ExcitationCriterion::kCondition, ExcitationCriterion::kDOptimal}) {
    for (const char* robot : {"psm-3dof", "psm-wrist", "kuka-lwr4"})
      compare(robot, criterion, seeds, solvers);
  }
  return 0;
}
