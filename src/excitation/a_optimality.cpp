#include "a_optimality.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "regressor/arm_columns.hpp"
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

RelativeDeviations::RelativeDeviations(const Model& arm, const BaseRegressor& regressor,
                                       VectorXd share, std::vector<MatrixXd> given)
    : beta_(regressor.combination() * standard_values(arm)),
      share_(std::move(share)),
      given_(std::move(given)) {
  const std::vector<MatrixXd> grams = regressor.columns()->joint_grams(random_states(arm, kStates));
  VectorXd square(arm.joints());
  for (Eigen::Index i = 0; i < square.size(); ++i)
    square[i] = beta_.dot(grams[static_cast<size_t>(i)] * beta_) / kStates;
  const double none = std::max(1e-300, kNoTorque2 * square.maxCoeff());
  least_square_ = (std::pow(kLeastTorque, 2) * square).cwiseMax(none);
  VectorXd by_one = VectorXd::Zero(beta_.size());  // squared torque of one unit, relative
  for (Eigen::Index i = 0; i < square.size(); ++i)
    by_one += grams[static_cast<size_t>(i)].diagonal() / kStates / (square[i] + least_square_[i]);
  size_ = beta_.cwiseAbs().cwiseMax(kFloorOfTorque *
                                    by_one.cwiseMax(1e-300).cwiseSqrt().cwiseInverse());
}

SmoothJointValue RelativeDeviations::operator()(const std::vector<MatrixXd>& grams) const {
  const Eigen::Index count = beta_.size();
  MatrixXd M = MatrixXd::Zero(count, count);
  VectorXd weight(static_cast<Eigen::Index>(grams.size()));
  for (size_t i = 0; i < grams.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    weight[at] =
        1.0 / (share_[at] * share_[at] * (beta_.dot(grams[i] * beta_) + least_square_[at]));
    M += weight[at] * (grams[i] + given_[i]);
  }
  const MatrixXd P = inverse_of(M);
  const VectorXd deviation = P.diagonal().cwiseMax(1e-300).cwiseSqrt();
  const double mean = deviation.cwiseQuotient(size_).mean();
  SmoothJointValue out;
  out.value = std::log(mean);
  const VectorXd by_variance =
      (0.5 / (mean * static_cast<double>(count)) / (deviation.array() * size_.array())).matrix();
  const MatrixXd by_M = -P * by_variance.asDiagonal() * P;
  const MatrixXd square = beta_ * beta_.transpose();
  for (size_t i = 0; i < grams.size(); ++i) {
    const double w = weight[static_cast<Eigen::Index>(i)];
    const double share = share_[static_cast<Eigen::Index>(i)];
    const double through_noise =
        by_M.cwiseProduct(grams[i] + given_[i]).sum() * w * w * share * share;
    out.by_gram.push_back(w * by_M - through_noise * square);
  }
  return out;
}

}  // namespace veridyn
