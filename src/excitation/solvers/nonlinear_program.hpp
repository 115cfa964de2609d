#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// A program for the solvers: minimise f(x) subject to lower <= c(x) <= upper, with exact derivatives.
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
  /// Called from time to time; true ends the search.
  std::function<bool()> stop;
};

struct SolverResult {
  VectorXd x;
  bool converged = false;
  int iterations = 0;
};

using NonlinearSolver =
    std::function<SolverResult(NonlinearProgram&, const VectorXd& start, const SolverOptions&)>;

/// Primal-dual interior point with slacks, a line search and a dense, damped BFGS Hessian; each
/// step is one Cholesky factor of the size of the variables, however many constraints there are.
/// For up to some hundred variables (Nocedal and Wright, Numerical Optimization, 2006, chapter 19).
SolverResult solve_with_interior_point(NonlinearProgram& program, const VectorXd& start,
                                       const SolverOptions& options);

/// Ipopt (Waechter and Biegler, Mathematical Programming 106(1), 2006) with the same dense BFGS matrix as its
/// Hessian, and NLopt's sequential quadratic programming (SLSQP, Kraft 1988). Both receive only the limits that
/// can become active, see working_set.hpp. They exist if their packages are installed.
SolverResult solve_with_ipopt(NonlinearProgram& program, const VectorXd& start,
                              const SolverOptions& options);
SolverResult solve_with_nlopt(NonlinearProgram& program, const VectorXd& start,
                              const SolverOptions& options);

/// Damped BFGS updating, procedure 18.2 of Nocedal and Wright: B stays positive definite.
/// @param s_k, y_k  change of x and of the Lagrangian's gradient.
/// @param first  true: B has no curvature yet, and its scale is chosen first.
void update_hessian(MatrixXd& B, const VectorXd& s_k, const VectorXd& y_k, bool first);

}  // namespace veridyn
