#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "veridyn/model/model.hpp"

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
  /// @param A  (k x k) its lower triangle is read.
  explicit RidgedSolver(MatrixXd A);
  VectorXd solve(const VectorXd& b) const { return factor_.solve(b); }
  MatrixXd solve_columns(const MatrixXd& B) const { return factor_.solve(B); }

 private:
  Eigen::LDLT<MatrixXd> factor_;
};

/// The same for columns of any size: scaled to a diagonal of ones first.
VectorXd solve_scaled(const MatrixXd& A, const VectorXd& b);

/// Standard deviations by the jackknife, (k): `without` (k x g) holds the estimates that leave one
/// of g clusters out.
///
///   s^2 = (g - 1) / g * sum_c (x_c - mean x)^2
VectorXd jackknife_deviations(const MatrixXd& without);

/// Covariance by the jackknife, (k x k).
MatrixXd jackknife_covariance(const MatrixXd& without);

/// p value of all parameters together over g clusters, by Hotelling's statistic: parameters that
/// share one cause may each be uncertain while their sum is not.
double wald_p_value(const VectorXd& x, const MatrixXd& without);

double median(std::vector<double> values);

}  // namespace veridyn
