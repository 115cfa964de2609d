#include "diagnosis/evidence/clustered_fit.hpp"

#include <Eigen/QR>

#include "diagnosis/evidence/numerics.hpp"
#include "math/student_t.hpp"

namespace veridyn {

RidgedSolver::RidgedSolver(MatrixXd A, double ridge) {
  A.diagonal() += ridge * A.diagonal().cwiseMax(numerics::kTiny);
  factor_.compute(A);
}

VectorXd solve_scaled(const MatrixXd& A, const VectorXd& b) {
  const VectorXd scale =
      A.diagonal().cwiseMax(numerics::kTiny).cwiseSqrt().cwiseInverse();
  const RidgedSolver solver(scale.asDiagonal() * A * scale.asDiagonal());
  return scale.asDiagonal() * solver.solve(scale.asDiagonal() * b);
}

VectorXd solve_general(const MatrixXd& A, const VectorXd& b) {
  return Eigen::ColPivHouseholderQR<MatrixXd>(A).solve(b);
}

double wald_p_value(const VectorXd& x, const MatrixXd& without) {
  const auto g = static_cast<double>(without.cols());
  const auto k = static_cast<double>(x.size());
  const double T2 = x.dot(solve_scaled(jackknife_covariance(without), x));
  return fisher_f_upper_tail(T2 * (g - k) / (k * (g - 1.0)), k, g - k);
}

}  // namespace veridyn
