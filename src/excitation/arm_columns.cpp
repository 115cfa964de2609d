#include "arm_columns.hpp"

#include <algorithm>

#include "math/random_numbers.hpp"
#include "veridyn/kinematics/motion_limits.hpp"

namespace veridyn {
namespace {

constexpr unsigned kStateSeed = 7;
constexpr double kIndependent = 1e-6;  // what must be left of a column of norm one

}  // namespace

std::vector<std::shared_ptr<const ColumnSource>> arm_columns(const Model& arm, double rounding) {
  std::vector<std::shared_ptr<const ColumnSource>> out{body_columns(arm)};
  const VectorXd speeds = rounding * motion_limits(arm).velocity;
  for (const EffectTerm& term : arm.effects()) out.push_back(effect_columns(arm, term, speeds));
  return out;
}

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

std::vector<int> base_preference(int body_columns, int columns) {
  std::vector<int> order;
  for (int c = body_columns; c < columns; ++c) order.push_back(c);
  for (int c = 0; c < body_columns; ++c) {
    if (c % kBodyParameters != 0) order.push_back(c);
  }
  for (int c = 0; c < body_columns; c += kBodyParameters) order.push_back(c);
  return order;
}

std::vector<int> independent_columns(const MatrixXd& W, const std::vector<int>& order,
                                     const std::vector<int>& taken) {
  const double largest = W.colwise().norm().maxCoeff();
  MatrixXd Q(W.rows(), std::min<Eigen::Index>(W.rows(), W.cols()));
  Eigen::Index rank = 0;
  const auto is_new = [&](int c) {
    const double norm = W.col(c).norm();
    if (norm <= 1e-14 * largest || rank == Q.cols()) return false;
    VectorXd v = W.col(c) / norm;
    const auto basis = Q.leftCols(rank);
    v -= basis * (basis.transpose() * v);
    v -= basis * (basis.transpose() * v);
    if (v.norm() < kIndependent) return false;
    Q.col(rank++) = v / v.norm();
    return true;
  };
  for (const int c : taken) is_new(c);
  std::vector<int> chosen;
  for (const int c : order) {
    if (is_new(c)) chosen.push_back(c);
  }
  return chosen;
}

}  // namespace veridyn
