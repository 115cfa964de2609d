#include <nlopt.h>

#include <cmath>
#include <memory>

#include "excitation/search/nonlinear_program.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kTolerance = 1e-7;  // of the constraints

struct Problem {
  NonlinearProgram& program;
  const SolverOptions& options;
  nlopt_opt solver = nullptr;
  std::vector<int> below{};  // constraints with an upper bound
  std::vector<int> above{};  // with a lower one
};

double objective(unsigned n, const double* at, double* gradient, void* data) {
  auto& problem = *static_cast<Problem*>(data);
  if (problem.options.stop && problem.options.stop()) nlopt_force_stop(problem.solver);
  const VectorXd x = Eigen::Map<const VectorXd>(at, n);
  if (gradient != nullptr) Eigen::Map<VectorXd>(gradient, n) = problem.program.gradient(x);
  return problem.program.objective(x);
}

// c - upper and lower - c, at most zero.
void constraints(unsigned m, double* result, unsigned n, const double* at, double* gradient,
                 void* data) {
  auto& problem = *static_cast<Problem*>(data);
  const VectorXd x = Eigen::Map<const VectorXd>(at, n);
  const VectorXd c = problem.program.constraints(x);
  size_t k = 0;
  std::vector<int> row_below(static_cast<size_t>(c.size()), -1);
  std::vector<int> row_above(static_cast<size_t>(c.size()), -1);
  for (const int i : problem.below) {
    row_below[static_cast<size_t>(i)] = static_cast<int>(k);
    result[k++] = c[i] - problem.program.upper()[i];
  }
  for (const int i : problem.above) {
    row_above[static_cast<size_t>(i)] = static_cast<int>(k);
    result[k++] = problem.program.lower()[i] - c[i];
  }
  if (gradient == nullptr) return;
  std::fill(gradient, gradient + static_cast<size_t>(m) * n, 0.0);
  const VectorXd values = problem.program.jacobian(x);
  const auto& pattern = problem.program.pattern();
  for (size_t e = 0; e < pattern.size(); ++e) {
    const auto row = static_cast<size_t>(pattern[e].first);
    const auto column = static_cast<size_t>(pattern[e].second);
    const double value = values[static_cast<Eigen::Index>(e)];
    if (row_below[row] >= 0) gradient[static_cast<size_t>(row_below[row]) * n + column] += value;
    if (row_above[row] >= 0) gradient[static_cast<size_t>(row_above[row]) * n + column] -= value;
  }
}

struct Destroy {
  void operator()(nlopt_opt solver) const { nlopt_destroy(solver); }
};
using Handle = std::unique_ptr<std::remove_pointer_t<nlopt_opt>, Destroy>;

}  // namespace

SolverResult solve_with_nlopt(NonlinearProgram& program, const VectorXd& start, NloptMethod method,
                              const SolverOptions& options) {
  const auto n = static_cast<unsigned>(program.variables());
  const Handle outer(nlopt_create(NLOPT_AUGLAG, n));
  const bool exact = method == NloptMethod::kGradient;
  const Handle inner(nlopt_create(exact ? NLOPT_LD_LBFGS : NLOPT_LN_SBPLX, n));
  require(outer && inner, "NLopt: it could not be started.");
  Problem problem{program, options, outer.get()};
  for (int i = 0; i < program.lower().size(); ++i) {
    if (std::isfinite(program.upper()[i])) problem.below.push_back(i);
    if (std::isfinite(program.lower()[i])) problem.above.push_back(i);
  }
  // Functions and not the clock end the search: the same start gives the same result.
  const int evaluations = exact ? options.iterations : 20 * options.iterations;
  nlopt_set_xtol_rel(inner.get(), 0.1 * options.tolerance);
  nlopt_set_ftol_rel(inner.get(), 0.1 * options.tolerance);
  nlopt_set_maxeval(inner.get(), evaluations / 5);
  nlopt_set_local_optimizer(outer.get(), inner.get());
  nlopt_set_min_objective(outer.get(), objective, &problem);
  const auto rows = static_cast<unsigned>(problem.below.size() + problem.above.size());
  const VectorXd tolerances = VectorXd::Constant(rows, kTolerance);
  if (rows > 0) {
    nlopt_add_inequality_mconstraint(outer.get(), rows, constraints, &problem, tolerances.data());
  }
  nlopt_set_maxeval(outer.get(), evaluations);
  nlopt_set_ftol_rel(outer.get(), options.tolerance);
  SolverResult out;
  out.x = start;
  double value = 0.0;
  const nlopt_result status = nlopt_optimize(outer.get(), out.x.data(), &value);
  out.converged = status > 0 && status != NLOPT_MAXEVAL_REACHED;
  out.iterations = nlopt_get_numevals(outer.get());
  return out;
}

}  // namespace veridyn
