#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "diagnosis/evidence/numerics.hpp"
#include "math/clustered_statistics.hpp"

namespace veridyn {

/// The one least-squares solver of diagnosis: normal equations of columns of equal size with a
/// ridge that keeps equal columns from dividing by zero,
///
///   (A + 1e-11 diag(A)) x = b
///
/// Factors keep the accuracy of the data; questions of evidence need no more than half the digits.
class RidgedSolver {
 public:
  RidgedSolver() = default;
  /// @param A      (k x k) its lower triangle is read.
  /// @param ridge  share of every diagonal entry that is added to it.
  explicit RidgedSolver(MatrixXd A, double ridge = numerics::kRidge);
  VectorXd solve(const VectorXd& b) const { return factor_.solve(b); }
  MatrixXd solve_columns(const MatrixXd& B) const { return factor_.solve(B); }

 private:
  Eigen::LDLT<MatrixXd> factor_;
};

/// The same for columns of any size: scaled to a diagonal of ones first.
VectorXd solve_scaled(const MatrixXd& A, const VectorXd& b);

/// Least squares of any rows, or a square system without symmetry.
VectorXd solve_general(const MatrixXd& A, const VectorXd& b);

/// p value of all parameters together over g clusters, by Hotelling's statistic: parameters that
/// share one cause may each be uncertain while their sum is not.
double wald_p_value(const VectorXd& x, const MatrixXd& without);

}  // namespace veridyn
