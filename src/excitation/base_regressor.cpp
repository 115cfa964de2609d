#include "veridyn/excitation/base_regressor.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "math/random_numbers.hpp"
#include "veridyn/kinematics/motion_limits.hpp"

namespace veridyn {
namespace {

constexpr unsigned kStateSeed = 7;
constexpr double kIndependent = 1e-6;        // what must be left of a column of norm one
constexpr double kLargestCondition2 = 1e14;  // squared; eigenvalues of a Gram matrix know no more

MotionSamples random_states(const Model& arm, int count) {
  RandomNumbers random(kStateSeed);
  const MotionLimits limits = motion_limits(arm);
  const int n = arm.joints();
  MotionSamples out{VectorXd::LinSpaced(count, 0.0, 1.0), MatrixXd(count, n), MatrixXd(count, n),
                    MatrixXd(count, n)};
  for (int k = 0; k < count; ++k) {
    for (int i = 0; i < n; ++i) {
      out.q(k, i) = random.uniform(limits.lower[i], limits.upper[i]);
      out.dq(k, i) = limits.velocity[i] * random.uniform(-1.0, 1.0);
      out.ddq(k, i) = 5.0 * limits.velocity[i] * random.uniform(-1.0, 1.0);
    }
  }
  return out;
}

// Effects, then what is not a mass, then the masses: as base parameters are commonly given.
std::vector<int> preference(int body_columns, int columns) {
  std::vector<int> order;
  for (int c = body_columns; c < columns; ++c) order.push_back(c);
  for (int c = 0; c < body_columns; ++c) {
    if (c % kBodyParameters != 0) order.push_back(c);
  }
  for (int c = 0; c < body_columns; c += kBodyParameters) order.push_back(c);
  return order;
}

// Gram-Schmidt, twice for accuracy.
std::vector<int> independent_columns(const MatrixXd& W, const std::vector<int>& order) {
  const double largest = W.colwise().norm().maxCoeff();
  MatrixXd Q(W.rows(), std::min<Eigen::Index>(W.rows(), W.cols()));
  std::vector<int> chosen;
  for (const int c : order) {
    const double norm = W.col(c).norm();
    if (norm <= 1e-14 * largest) continue;
    VectorXd v = W.col(c) / norm;
    const auto basis = Q.leftCols(static_cast<Eigen::Index>(chosen.size()));
    v -= basis * (basis.transpose() * v);
    v -= basis * (basis.transpose() * v);
    if (v.norm() < kIndependent) continue;
    Q.col(static_cast<Eigen::Index>(chosen.size())) = v / v.norm();
    chosen.push_back(c);
  }
  return chosen;
}

}  // namespace

BaseRegressor::BaseRegressor(const Model& arm) : arm_(arm), bodies_(arm) {
  const int body_columns = kBodyParameters * static_cast<int>(arm.bodies().size());
  column_count_ = body_columns;
  for (int i = 0; i < arm.joints(); ++i) of_joint_.push_back(bodies_.columns(i));
  for (const EffectTerm& term : arm.effects()) {
    effects_.emplace_back(arm, term);
    for (int p = 0; p < effects_.back().parameter_count(); ++p, ++column_count_) {
      for (int i = 0; i < arm.joints(); ++i) {
        if (term.axis.coefficients[i] != 0.0)
          of_joint_[static_cast<size_t>(i)].push_back(column_count_);
      }
    }
  }
  const int states = 20 + 2 * column_count_ / std::max(1, arm.joints());
  const MatrixXd W = stacked(random_states(arm, states));
  base_ = independent_columns(W, preference(body_columns, column_count_));
  place_.assign(static_cast<size_t>(column_count_), -1);
  scale_.resize(size());
  for (int b = 0; b < size(); ++b) {
    place_[static_cast<size_t>(base_[static_cast<size_t>(b)])] = b;
    scale_[b] =
        W.col(base_[static_cast<size_t>(b)]).norm() / std::sqrt(static_cast<double>(states));
  }
}

std::vector<MatrixXd> BaseRegressor::columns_by_joint(const MotionSamples& motion) const {
  const Eigen::Index rows = motion.rows();
  std::vector<MatrixXd> Y(of_joint_.size());
  std::vector<MatrixXd> body_columns(of_joint_.size());
  bodies_.evaluate(motion.q, motion.dq, motion.ddq, body_columns);
  std::vector<Eigen::Index> filled(of_joint_.size());
  for (size_t i = 0; i < Y.size(); ++i) {
    Y[i].resize(rows, static_cast<Eigen::Index>(of_joint_[i].size()));
    filled[i] = body_columns[i].cols();
    Y[i].leftCols(filled[i]) = body_columns[i];
  }
  MatrixXd load = MatrixXd::Zero(rows, motion.joints());
  const auto phi = arm_.inertial_values();
  const auto needs_load = [](const BoundEffect& e) { return e.effect().needs_load(); };
  if (phi && std::any_of(effects_.begin(), effects_.end(), needs_load)) {
    bodies_.torques(motion.q, motion.dq, motion.ddq, *phi, load);
  }
  EffectColumns row{};
  for (BoundEffect effect : effects_) {  // a copy: memory belongs to this call
    effect.reset(motion.time[0]);
    const VectorXd& c = effect.term().axis.coefficients;
    MatrixXd columns(rows, effect.parameter_count());
    for (Eigen::Index k = 0; k < rows; ++k) {
      AxisSample x = effect.sample(motion.time[k], motion.q.data() + k, motion.dq.data() + k,
                                   motion.ddq.data() + k, rows);
      x.load = load.row(k).dot(c) / c.squaredNorm();
      effect.columns(x, row);
      for (int p = 0; p < effect.parameter_count(); ++p)
        columns(k, p) = row[static_cast<size_t>(p)];
    }
    for (size_t i = 0; i < Y.size(); ++i) {
      const double share = c[static_cast<Eigen::Index>(i)];
      if (share == 0.0) continue;
      Y[i].middleCols(filled[i], columns.cols()) = share * columns;
      filled[i] += columns.cols();
    }
  }
  return Y;
}

MatrixXd BaseRegressor::stacked(const MotionSamples& motion) const {
  const std::vector<MatrixXd> Y = columns_by_joint(motion);
  MatrixXd W = MatrixXd::Zero(motion.rows() * motion.joints(), column_count_);
  for (size_t i = 0; i < Y.size(); ++i) {
    for (Eigen::Index c = 0; c < Y[i].cols(); ++c) {
      W.col(of_joint_[i][static_cast<size_t>(c)])
          .segment(static_cast<Eigen::Index>(i) * motion.rows(), motion.rows()) = Y[i].col(c);
    }
  }
  return W;
}

MatrixXd BaseRegressor::gram(const MotionSamples& motion) const {
  const std::vector<MatrixXd> Y = columns_by_joint(motion);
  MatrixXd G = MatrixXd::Zero(size(), size());
  for (size_t i = 0; i < Y.size(); ++i) {
    std::vector<int> places;
    MatrixXd W(motion.rows(), Y[i].cols());
    for (Eigen::Index c = 0; c < Y[i].cols(); ++c) {
      const int place = place_[static_cast<size_t>(of_joint_[i][static_cast<size_t>(c)])];
      if (place < 0) continue;
      W.col(static_cast<Eigen::Index>(places.size())) = Y[i].col(c);
      places.push_back(place);
    }
    const auto count = static_cast<Eigen::Index>(places.size());
    const MatrixXd part = W.leftCols(count).transpose() * W.leftCols(count);
    for (Eigen::Index c = 0; c < count; ++c) {
      for (Eigen::Index r = 0; r < count; ++r)
        G(places[static_cast<size_t>(r)], places[static_cast<size_t>(c)]) += part(r, c);
    }
  }
  return G;
}

double scaled_condition_number(const MatrixXd& gram) {
  const double infinity = std::numeric_limits<double>::infinity();
  const VectorXd norms = gram.diagonal().cwiseSqrt();
  if (gram.size() == 0 || !(norms.minCoeff() > 0.0)) return infinity;
  const VectorXd inverse = norms.cwiseInverse();
  const MatrixXd scaled = inverse.asDiagonal() * gram * inverse.asDiagonal();
  const VectorXd values =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(scaled, Eigen::EigenvaluesOnly).eigenvalues();
  const double smallest = values[0];
  const double largest = values[values.size() - 1];
  return largest < kLargestCondition2 * smallest ? std::sqrt(largest / smallest) : infinity;
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
