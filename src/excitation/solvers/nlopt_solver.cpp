#include <nlopt.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "excitation/solvers/nonlinear_program.hpp"
#include "excitation/solvers/working_set.hpp"

namespace veridyn {
namespace {

constexpr double kLimitTolerance = 1e-7;  // tolerance as a share of a limit's scale
constexpr double kSmallestGain = 1e-5;    // relative decrease that ends a descent

struct NloptProblem {
  NonlinearProgram& program;
  const SolverOptions& options;
  nlopt_opt solver;
  // Index of the constraint, and sign: +1 for an upper bound, -1 for a lower one.
  std::vector<std::pair<int, double>> rows;
};

double nlopt_objective(unsigned n, const double* at, double* gradient, void* data) {
  auto& p = *static_cast<NloptProblem*>(data);
  if (p.options.stop && p.options.stop()) nlopt_force_stop(p.solver);
  const VectorXd x = Eigen::Map<const VectorXd>(at, n);
  const double value = p.program.objective(x);
  if (gradient != nullptr) Eigen::Map<VectorXd>(gradient, n) = p.program.gradient(x);
  return value;
}

void nlopt_constraints(unsigned m, double* result, unsigned n, const double* at, double* gradient,
                 void* data) {
  auto& p = *static_cast<NloptProblem*>(data);
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

SolverResult slsqp(NonlinearProgram& program, const VectorXd& start, const SolverOptions& options) {
  const auto n = static_cast<unsigned>(program.variables());
  const std::unique_ptr<std::remove_pointer_t<nlopt_opt>, void (*)(nlopt_opt)> solver(
      nlopt_create(NLOPT_LD_SLSQP, n), nlopt_destroy);
  NloptProblem problem{program, options, solver.get(), {}};
  for (int i = 0; i < program.lower().size(); ++i) {
    if (std::isfinite(program.upper()[i])) problem.rows.emplace_back(i, 1.0);
    if (std::isfinite(program.lower()[i])) problem.rows.emplace_back(i, -1.0);
  }
  nlopt_set_min_objective(solver.get(), nlopt_objective, &problem);
  const auto rows = static_cast<unsigned>(problem.rows.size());
  const VectorXd tolerances = VectorXd::Constant(rows, kLimitTolerance);
  if (rows > 0)
    nlopt_add_inequality_mconstraint(solver.get(), rows, nlopt_constraints, &problem, tolerances.data());
  nlopt_set_maxeval(solver.get(), options.iterations);
  nlopt_set_ftol_rel(solver.get(), kSmallestGain);
  SolverResult out{start};
  double value = 0.0;
  const nlopt_result status = nlopt_optimize(solver.get(), out.x.data(), &value);
  out.converged = status > 0 && status != NLOPT_MAXEVAL_REACHED;
  out.iterations = nlopt_get_numevals(solver.get());
  return out;
}

}  // namespace

SolverResult solve_with_nlopt(NonlinearProgram& program, const VectorXd& start, const SolverOptions& options) {
  return with_working_set(slsqp, program, start, options);
}

}  // namespace veridyn
