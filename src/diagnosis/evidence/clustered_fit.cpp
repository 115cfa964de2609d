#include "diagnosis/evidence/clustered_fit.hpp"

#include <algorithm>

#include "diagnosis/numerics.hpp"
#include "math/student_t.hpp"

namespace veridyn {

RidgedSolver::RidgedSolver(MatrixXd A) {
  A.diagonal() += numerics::kRidge * A.diagonal().cwiseMax(numerics::kTiny);
  factor_.compute(A);
}

VectorXd solve_scaled(const MatrixXd& A, const VectorXd& b) {
  const VectorXd scale =
      A.diagonal().cwiseMax(numerics::kTiny).cwiseSqrt().cwiseInverse();
  const RidgedSolver solver(scale.asDiagonal() * A * scale.asDiagonal());
  return scale.asDiagonal() * solver.solve(scale.asDiagonal() * b);
}

MatrixXd jackknife_covariance(const MatrixXd& without) {
  const auto g = static_cast<double>(without.cols());
  const MatrixXd centred = without.colwise() - without.rowwise().mean();
  return centred * centred.transpose() * ((g - 1.0) / g);
}

VectorXd jackknife_deviations(const MatrixXd& without) {
  const auto g = static_cast<double>(without.cols());
  const MatrixXd centred = without.colwise() - without.rowwise().mean();
  return (centred.rowwise().squaredNorm() * ((g - 1.0) / g)).cwiseSqrt();
}

double wald_p_value(const VectorXd& x, const MatrixXd& without) {
  const auto g = static_cast<double>(without.cols());
  const auto k = static_cast<double>(x.size());
  const double T2 = x.dot(solve_scaled(jackknife_covariance(without), x));
  return fisher_f_upper_tail(T2 * (g - k) / (k * (g - 1.0)), k, g - k);
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace veridyn
