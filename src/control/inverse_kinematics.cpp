#include "veridyn/control/inverse_kinematics.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr int kMostHalvings = 12;

}  // namespace

const char* name_of(ReachStatus status) {
  static constexpr const char* kNames[] = {"reached", "not reached", "outside limits", "singular", "out of reach"};
  return kNames[static_cast<int>(status)];
}

InverseKinematics::InverseKinematics(const Model& arm, const Tip& tip,
                                     const InverseKinematicsOptions& options)
    : options_(options),
      kinematics_(arm, tip),
      inverse_(arm, tip, options.rows, options.inverse),
      lower_(arm.joints()),
      upper_(arm.joints()),
      unit_(VectorXd::Ones(arm.joints())),
      rest_(VectorXd::Zero(arm.joints())),
      move_(rest_),
      trial_(rest_) {
  require(options.position_tolerance > 0.0 && options.angle_tolerance > 0.0 &&
              options.most_iterations > 0 && options.longest_step > 0.0,
          "InverseKinematics: found a tolerance, step or number of iterations that is not above "
          "zero.");
  for (int i = 0; i < arm.joints(); ++i) {
    const Coordinate& c = arm.coordinates()[i];
    lower_[i] = c.limits.lower;
    upper_[i] = c.limits.upper;
    if (c.prismatic) unit_[i] = inverse_.length();
  }
}

// Computes the error of the pose at q; returns its norm in characteristic lengths and radians.
double InverseKinematics::measure(const Eigen::Vector3d& position, const Eigen::Matrix3d& R,
                                  const VectorRef& q, Vector6d& e) noexcept {
  kinematics_.update(q, rest_);
  e.head<3>() = position - kinematics_.position();
  e.tail<3>().setZero();
  position_error_ = e.head<3>().norm();
  angle_error_ = 0.0;
  if (options_.rows == TaskRows::kPose) {
    const Eigen::AngleAxisd turn(R * kinematics_.rotation().transpose());
    e.tail<3>() = turn.angle() * turn.axis();
    angle_error_ = std::abs(turn.angle());
  }
  return std::hypot(position_error_ / inverse_.length(), angle_error_);
}

// Computes the step from q; joints that would leave their range stay where they are.
void InverseKinematics::step(const Vector6d& e, const VectorRef& q) noexcept {
  inverse_.release();
  for (Eigen::Index round = 0; round <= q.size(); ++round) {
    inverse_.update(kinematics_.jacobian());
    inverse_.solve(e, rest_, move_);
    bool again = false;
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const bool outward =
          (q[i] >= upper_[i] && move_[i] > 0.0) || (q[i] <= lower_[i] && move_[i] < 0.0);
      if (!outward || inverse_.held(static_cast<int>(i))) continue;
      inverse_.hold(static_cast<int>(i));
      again = true;
    }
    if (!again) break;
  }
  double longest = 0.0;
  for (Eigen::Index i = 0; i < q.size(); ++i)
    longest = std::max(longest, std::abs(move_[i]) / unit_[i]);
  if (longest > options_.longest_step) move_ *= options_.longest_step / longest;
}

bool InverseKinematics::reached() const {
  return position_error_ <= options_.position_tolerance && angle_error_ <= options_.angle_tolerance;
}

ReachStatus InverseKinematics::solve(const Eigen::Vector3d& position, const Eigen::Matrix3d& R,
                                     VectorXd& q) noexcept {
  assert(q.size() == lower_.size());
  q = q.cwiseMax(lower_).cwiseMin(upper_);
  Vector6d e;
  double error = measure(position, R, q, e);
  for (iterations_ = 0; iterations_ < options_.most_iterations && !reached(); ++iterations_) {
    step(e, q);
    double share = 1.0;
    bool better = false;
    for (int k = 0; k < kMostHalvings && !better; ++k, share *= 0.5) {
      trial_ = (q + share * move_).cwiseMax(lower_).cwiseMin(upper_);
      const double tried = measure(position, R, trial_, e);
      better = tried < error;  // false for a NaN target
      if (better) error = tried;
    }
    if (!better) break;
    q = trial_;
  }
  measure(position, R, q, e);
  return reached() ? ReachStatus::kReached : ReachStatus::kNotReached;
}

}  // namespace veridyn
