#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// minimise f(x) subject to lower <= c(x) <= upper, with exact derivatives; what the solvers see.
class NonlinearProgram {
 public:
  virtual ~NonlinearProgram() = default;

  virtual int variables() const = 0;
  virtual double objective(const VectorXd& x) = 0;
  virtual VectorXd gradient(const VectorXd& x) = 0;

  /// Bounds of the constraints; infinite where there is none.
  virtual const VectorXd& lower() const = 0;
  virtual const VectorXd& upper() const = 0;
  virtual VectorXd constraints(const VectorXd& x) = 0;

  /// Row and column of every entry of the Jacobian that can differ from zero, and their values.
  virtual const std::vector<std::pair<int, int>>& pattern() const = 0;
  virtual VectorXd jacobian(const VectorXd& x) = 0;
};

struct SolverOptions {
  int iterations = 300;
  double tolerance = 1e-4;
  /// Asked now and then; true ends the search.
  std::function<bool()> stop;
};

struct SolverResult {
  VectorXd x;
  bool converged = false;
  int iterations = 0;
};

/// Primal-dual interior point with slacks, a line search and a dense, damped BFGS Hessian; each
/// step is one Cholesky factor of the size of the variables, however many constraints there are.
/// For up to some hundred variables (Nocedal and Wright, Numerical Optimization, 2006, chapter 19).
SolverResult solve_with_interior_point(NonlinearProgram& program, const VectorXd& start,
                                       const SolverOptions& options);

/// Interior point with exact gradients and Jacobian and an L-BFGS Hessian (Waechter and Biegler,
/// Mathematical Programming 106(1), 2006). Several at once are safe: the solver's own code takes
/// turns, the functions run side by side.
SolverResult solve_with_ipopt(NonlinearProgram& program, const VectorXd& start,
                              const SolverOptions& options);

enum class NloptMethod {
  kGradient,        ///< augmented Lagrangian over L-BFGS
  kDerivativeFree,  ///< augmented Lagrangian over Subplex
};

/// Augmented Lagrangian (Birgin and Martinez, Optimization Methods and Software 23(2), 2008) over a
/// method without constraints.
SolverResult solve_with_nlopt(NonlinearProgram& program, const VectorXd& start, NloptMethod method,
                              const SolverOptions& options);

}  // namespace veridyn
