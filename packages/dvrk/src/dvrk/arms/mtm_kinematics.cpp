#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "kinematic_form.hpp"

namespace veridyn::dvrk {
namespace {

constexpr double kRight = M_PI / 2.0;

Eigen::Matrix3d turn(double angle, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

Eigen::Matrix3d turn_x(double angle) {
  return turn(angle, Eigen::Vector3d::UnitX());
}

Eigen::Matrix3d turn_z(double angle) {
  return turn(angle, Eigen::Vector3d::UnitZ());
}

// Rotation from the platform to the last axis, without that axis' own angle.
Eigen::Matrix3d wrist_rotation(double pitch, double yaw) {
  return turn_x(kRight) * turn_z(pitch) * turn_x(-kRight) * turn_z(yaw + kRight) * turn_x(-kRight);
}

}  // namespace

MtmKinematics::MtmKinematics(const ArmFacts& arm)
    : T_tip_last_(arm.T_last_tip.inverse().matrix()),
      ranges_(arm),
      position_ranges_(arm) {
  require_form(arm, {{0.0, 0.0, {}, 0.0},
                     {0.0, -kRight, 0.0, kRight},
                     {{}, 0.0, 0.0, kRight},
                     {{}, -kRight, {}, 0.0},
                     {0.0, kRight, 0.0, 0.0},
                     {0.0, -kRight, 0.0, kRight},
                     {0.0, -kRight, 0.0, M_PI}});
  height_ = arm.joints[0].dh->d;
  upper_ = arm.joints[2].dh->a;
  forearm_ = arm.joints[3].dh->a;
  offset_ = arm.joints[3].dh->d;
}

Eigen::Matrix3d MtmKinematics::platform_orientation(const Joints& q) const noexcept {
  return turn_z(q[0]) * turn_x(-kRight) * turn_z(q[1] + q[2] + M_PI) * turn_x(-kRight) *
         turn_z(q[3]);
}

InverseSolution<3> MtmKinematics::inverse_position(const Eigen::Vector3d& wrist,
                                                   const Eigen::Vector3d& near) const noexcept {
  SolutionChoice<3> choice(position_ranges_, near);
  const double reach = std::hypot(forearm_, offset_);
  const double bend = std::atan2(offset_, forearm_);
  const double radius = std::hypot(wrist.x(), wrist.y());
  const double down = height_ - wrist.z();
  const double cosine =
      (radius * radius + down * down - upper_ * upper_ - reach * reach) / (2.0 * upper_ * reach);
  // Rounding may place a stretched arm slightly beyond its reach.
  if (!(std::abs(cosine) <= 1.0 + 1e-12) || !near.allFinite()) return choice.best();
  const double elbow = std::acos(std::clamp(cosine, -1.0, 1.0));
  const bool on_axis = radius < kSingularDistance;
  for (const double side : {1.0, -1.0}) {
    const double yaw = on_axis ? near[0] : std::atan2(side * wrist.y(), side * wrist.x());
    for (const double B : {elbow, -elbow}) {
      const double A = std::atan2(down, side * radius) -
                       std::atan2(reach * std::sin(B), upper_ + reach * std::cos(B));
      choice.add_candidate({yaw, A - kRight, B - kRight - bend}, on_axis);
    }
  }
  return choice.best();
}

InverseSolution<7> MtmKinematics::inverse(const Eigen::Matrix4d& T_base_tip,
                                          const Joints& near) const noexcept {
  SolutionChoice<7> choice(ranges_, near);
  if (!T_base_tip.allFinite() || !near.allFinite()) return choice.best();
  const Eigen::Matrix4d T = T_base_tip * T_tip_last_;
  const InverseSolution<3> place = inverse_position(T.topRightCorner<3, 1>(), near.head<3>());
  if (place.status == InverseStatus::kOutOfReach) return choice.best();
  Joints q = near;
  q.head<3>() = place.q;
  const Eigen::Matrix3d R47 = platform_orientation(q).transpose() * T.topLeftCorner<3, 3>();
  // The last column of R47 is (-c5 c6, -s6, -s5 c6).
  const double across = std::hypot(R47(0, 2), R47(2, 2));
  const bool singular = across < kSingularDistance || place.status == InverseStatus::kSingular;
  for (const double side : {1.0, -1.0}) {
    q[4] = across < kSingularDistance ? near[4] : std::atan2(-side * R47(2, 2), -side * R47(0, 2));
    q[5] = std::atan2(-R47(1, 2), side * across);
    const Eigen::Matrix3d roll = wrist_rotation(q[4], q[5]).transpose() * R47;
    q[6] = std::atan2(roll(1, 0), roll(0, 0)) - M_PI;
    choice.add_candidate(q, singular);
  }
  return choice.best();
}

}  // namespace veridyn::dvrk
