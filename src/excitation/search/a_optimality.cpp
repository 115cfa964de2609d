#include "a_optimality.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "regressor/stacked_columns.hpp"
#include "regressor/random_states.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn {
namespace {

constexpr int kStates = 400;
constexpr double kNoTorque2 = 1e-12;  // share of the largest joint's mean square
constexpr double kRidge = 1e-14;

// The inverse of a positive matrix, scaled to a diagonal of ones first; a ridge keeps it finite.
MatrixXd inverse_of(const MatrixXd& M) {
  const VectorXd d = M.diagonal().cwiseSqrt().cwiseMax(1e-150).cwiseInverse();
  const MatrixXd one = MatrixXd::Identity(M.rows(), M.cols());
  const MatrixXd scaled = d.asDiagonal() * M * d.asDiagonal();
  const Eigen::LLT<MatrixXd> llt(scaled + kRidge * one);
  if (llt.info() == Eigen::Success) return d.asDiagonal() * llt.solve(one) * d.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scaled);
  const VectorXd values = eigen.eigenvalues().cwiseMax(kRidge).cwiseInverse();
  const MatrixXd V = d.asDiagonal() * eigen.eigenvectors();
  return V * values.asDiagonal() * V.transpose();
}

}  // namespace

VectorXd parameter_sizes(const Model& arm, const BaseRegressor& regressor) {
  const VectorXd beta = regressor.combination() * standard_values(arm);
  const std::vector<MatrixXd> grams = regressor.columns()->joint_grams(random_states(arm, kStates));
  VectorXd square(arm.joints());
  for (Eigen::Index i = 0; i < square.size(); ++i)
    square[i] = beta.dot(grams[i] * beta) / kStates;
  const double none = std::max(1e-300, kNoTorque2 * square.maxCoeff());
  VectorXd by_one = VectorXd::Zero(beta.size());  // squared torque of one unit, relative
  for (Eigen::Index i = 0; i < square.size(); ++i)
    by_one += grams[i].diagonal() / kStates / std::max(square[i], none);
  return beta.cwiseAbs().cwiseMax(kFloorOfTorque *
                                  by_one.cwiseMax(1e-300).cwiseSqrt().cwiseInverse());
}

SmoothValue smooth_a_optimality(const MatrixXd& gram, const VectorXd& size) {
  const MatrixXd P = inverse_of(gram);
  const VectorXd deviation = P.diagonal().cwiseMax(1e-300).cwiseSqrt();
  const double mean = deviation.cwiseQuotient(size).mean();
  const VectorXd by_variance =
      (0.5 / (mean * static_cast<double>(size.size())) / (deviation.array() * size.array())).matrix();
  return {std::log(mean), -P * by_variance.asDiagonal() * P};
}

}  // namespace veridyn
