#include "veridyn/control/analytical_task.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "math/rotation.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kLeastCosine = 0.05;  // cosine of the pitch 3 degrees from the singularity of T

// The matrix T^-1, damped where cos(pitch) is small.
Eigen::Matrix3d omega_to_angle_rates(const Eigen::Vector3d& angles) {
  const double c = std::cos(angles.y());
  const double over_c = c / std::pow(std::max(std::abs(c), kLeastCosine), 2);
  const double s = std::sin(angles.y());
  const double cz = std::cos(angles.z());
  const double sz = std::sin(angles.z());
  Eigen::Matrix3d inverse;
  // clang-format off
  inverse <<     cz * over_c,     sz * over_c, 0,
                         -sz,              cz, 0,
             s * cz * over_c, s * sz * over_c, 1;
  // clang-format on
  return inverse;
}

}  // namespace

Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& R) noexcept {
  const double across = std::hypot(R(2, 1), R(2, 2));
  if (across < 1e-9) {
    // At the singularity roll and yaw turn about the same axis; the rotation is assigned to yaw.
    return {0.0, std::atan2(-R(2, 0), across), std::atan2(-R(0, 1), R(1, 1))};
  }
  return {std::atan2(R(2, 1), R(2, 2)), std::atan2(-R(2, 0), across), std::atan2(R(1, 0), R(0, 0))};
}

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& angles) noexcept {
  const double cx = std::cos(angles.x());
  const double sx = std::sin(angles.x());
  const double cy = std::cos(angles.y());
  const double sy = std::sin(angles.y());
  const double cz = std::cos(angles.z());
  const double sz = std::sin(angles.z());
  Eigen::Matrix3d R;
  // clang-format off
  R << cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx,
       sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx,
           -sy,                cy * sx,                cy * cx;
  // clang-format on
  return R;
}

Eigen::Matrix3d angle_rates_to_omega(const Eigen::Vector3d& angles) noexcept {
  const double cy = std::cos(angles.y());
  const double cz = std::cos(angles.z());
  const double sz = std::sin(angles.z());
  Eigen::Matrix3d T;
  // clang-format off
  T <<            cz * cy, -sz, 0,
                  sz * cy,  cz, 0,
       -std::sin(angles.y()), 0, 1;
  // clang-format on
  return T;
}

Eigen::Matrix3d angle_rates_to_omega_rate(const Eigen::Vector3d& angles,
                                          const Eigen::Vector3d& rates) noexcept {
  const double cy = std::cos(angles.y());
  const double sy = std::sin(angles.y());
  const double cz = std::cos(angles.z());
  const double sz = std::sin(angles.z());
  const double dy = rates.y();
  const double dz = rates.z();
  Eigen::Matrix3d dT;
  // clang-format off
  dT << -sz * cy * dz - cz * sy * dy, -cz * dz, 0,
         cz * cy * dz - sz * sy * dy, -sz * dz, 0,
                            -cy * dy,        0, 0;
  // clang-format on
  return dT;
}

AnalyticalTask::AnalyticalTask(int joints, TaskRows rows, const Eigen::Matrix3d& home)
    : rows_(rows), home_(home), J_(MatrixXd::Zero(6, joints)), dJ_(J_) {
  require(is_rotation(home, 1e-6),
          "AnalyticalTask: found a home that is no rotation, expected an orthonormal matrix.");
}

Vector6d AnalyticalTask::coordinates(const Eigen::Vector3d& position,
                                     const Eigen::Matrix3d& R_world_tip) const noexcept {
  Vector6d x = Vector6d::Zero();
  x.head<3>() = position;
  if (rows_ == TaskRows::kPose) x.tail<3>() = roll_pitch_yaw(home_.transpose() * R_world_tip);
  return x;
}

void AnalyticalTask::update(const TipKinematics& tip) noexcept {
  assert(tip.joints() == J_.cols());
  x_ = coordinates(tip.position(), tip.rotation());
  J_.topRows<3>() = tip.jacobian().topRows<3>();
  dJ_.topRows<3>() = tip.jacobian_rate().topRows<3>();
  dx_.head<3>() = tip.twist().head<3>();
  if (rows_ == TaskRows::kPosition) return;
  const Eigen::Vector3d angles = x_.tail<3>();
  const Eigen::Matrix3d inverse = omega_to_angle_rates(angles) * home_.transpose();
  const Eigen::Vector3d rates = inverse * tip.twist().tail<3>();
  dx_.tail<3>() = rates;
  // The rate of the Jacobian is d(T^-1 J)/dt = T^-1 (dJ - dT J_a).
  const Eigen::Matrix3d dT = home_ * angle_rates_to_omega_rate(angles, rates);
  for (Eigen::Index i = 0; i < J_.cols(); ++i) {
    const Eigen::Vector3d column = inverse * tip.jacobian().col(i).tail<3>();
    J_.col(i).tail<3>() = column;
    dJ_.col(i).tail<3>() = inverse * (tip.jacobian_rate().col(i).tail<3>() - dT * column);
  }
  T_A_.bottomRightCorner<3, 3>() = home_ * angle_rates_to_omega(angles);
}

Vector6d AnalyticalTask::wrench(const Vector6d& h_world) const noexcept {
  Vector6d h_a = h_world;
  if (rows_ == TaskRows::kPose)
    h_a.tail<3>() = T_A_.bottomRightCorner<3, 3>().transpose() * h_world.tail<3>();
  else
    h_a.tail<3>().setZero();
  return h_a;
}

Vector6d AnalyticalTask::difference(const Vector6d& x_wanted) const noexcept {
  Vector6d e = x_wanted - x_;
  for (int r = 3; r < 6; ++r) e[r] = std::remainder(e[r], 2.0 * M_PI);
  return e;
}

}  // namespace veridyn
