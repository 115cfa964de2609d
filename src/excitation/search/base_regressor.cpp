#include "excitation/search/base_regressor.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>
#include <limits>

#include "regressor/arm_columns.hpp"
#include "excitation/search/column_choice.hpp"
#include "regressor/random_states.hpp"
#include "regressor/stacked_columns.hpp"
#include "veridyn/identification/base_parameters.hpp"

namespace veridyn {
namespace {

// Largest squared condition number: the resolution of a Gram matrix's eigenvalues.
constexpr double kLargestCondition2 = 1e14;

constexpr double kNoPart = 1e-9;  // smallest share of a standard parameter in a base parameter

}  // namespace

BaseRegressor::BaseRegressor(const Model& arm, double rounding)
    : BaseRegressor(arm, {}, rounding) {}

BaseRegressor::BaseRegressor(const Model& arm, const std::vector<int>& base, double rounding)
    : ones_(VectorXd::Ones(arm.joints())), base_(base) {
  const StackedColumns exact(arm.joints(), arm_columns(arm, 0.0));
  const int states = state_count(exact.count(), arm.joints());
  const MatrixXd W = exact.stacked(random_states(arm, states));
  if (base_.empty()) {
    base_ = base_parameters(arm).independent;
    improve_choice(W, base_);
  }
  scale_.resize(size());
  for (int b = 0; b < size(); ++b) {
    scale_[b] =
        W.col(base_[b]).norm() / std::sqrt(static_cast<double>(states));
  }
  const MatrixXd R = W(Eigen::all, base_).householderQr().matrixQR().topRows(size());
  orthogonal_ = std::sqrt(static_cast<double>(states)) *
                R.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(size(), size()));
  combination_ = W(Eigen::all, base_).householderQr().solve(W);
  combination_ = (combination_.array().abs() < kNoPart).select(0.0, combination_);
  auto chosen = std::make_shared<StackedColumns>(arm.joints(), arm_columns(arm, rounding));
  chosen->choose(base_);
  columns_ = std::move(chosen);
}

MatrixXd BaseRegressor::gram(const MotionSamples& motion) const {
  return columns_->gram(motion, ones_);
}

MatrixXd BaseRegressor::gradient(const MotionSamples& motion, const MatrixXd& by_gram) const {
  return columns_->gradient(motion, ones_, by_gram);
}

MatrixXd BaseRegressor::stacked(const MotionSamples& motion) const {
  return columns_->stacked(motion)(Eigen::all, base_);
}

double plain_condition_number(const MatrixXd& gram) {
  const double infinity = std::numeric_limits<double>::infinity();
  if (gram.size() == 0) return infinity;
  const VectorXd values =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(gram, Eigen::EigenvaluesOnly).eigenvalues();
  const double smallest = values[0];
  const double largest = values[values.size() - 1];
  return largest < kLargestCondition2 * smallest ? std::sqrt(largest / smallest) : infinity;
}

double scaled_condition_number(const MatrixXd& gram) {
  const VectorXd norms = gram.diagonal().cwiseSqrt();
  if (gram.size() == 0 || !(norms.minCoeff() > 0.0)) return std::numeric_limits<double>::infinity();
  const VectorXd inverse = norms.cwiseInverse();
  return plain_condition_number(inverse.asDiagonal() * gram * inverse.asDiagonal());
}

double log_determinant(const MatrixXd& gram, const VectorXd& scale) {
  const double minus_infinity = -std::numeric_limits<double>::infinity();
  const VectorXd inverse = scale.cwiseInverse();
  const MatrixXd scaled = inverse.asDiagonal() * gram * inverse.asDiagonal();
  const Eigen::LDLT<MatrixXd> ldlt(scaled);
  const VectorXd pivots = ldlt.vectorD();
  if (pivots.size() == 0 || pivots.minCoeff() <= pivots.maxCoeff() / kLargestCondition2)
    return minus_infinity;
  return pivots.array().log().sum();
}

}  // namespace veridyn
