#include <Eigen/Geometry>
#include <cmath>

#include "kinematic_form.hpp"

namespace veridyn::dvrk {
namespace {

constexpr double kRight = M_PI / 2.0;

// Sets yaw and pitch [rad] of the shaft direction u. Along the axis of yaw any yaw is a solution: near_yaw, and
// `singular` is set.
void shaft_angles(const Eigen::Vector3d& u, double near_yaw, double& yaw, double& pitch, bool& singular) {
  const double across = std::hypot(u.x(), u.z());
  pitch = std::atan2(-u.y(), across);
  if (across < kSingularDistance) {
    singular = true;
    yaw = near_yaw;
  } else {
    yaw = std::atan2(u.x(), -u.z());
  }
}

Eigen::Matrix3d rotation_about_z(double angle) {
  const double s = std::sin(angle), c = std::cos(angle);
  Eigen::Matrix3d R;
  R << c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0;
  return R;
}

// The part of v perpendicular to the unit vector n, normalised; any such vector if v is along n.
Eigen::Vector3d unit_component_across(const Eigen::Vector3d& v, const Eigen::Vector3d& n) {
  const Eigen::Vector3d part = v - v.dot(n) * n;
  const double length = part.norm();
  if (length > 1e-6) return part / length;
  const Eigen::Vector3d other =
      std::abs(n.x()) < 0.7 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  return (other - other.dot(n) * n).normalized();
}

}  // namespace

PsmKinematics::PsmKinematics(const ArmFacts& arm)
    : T_tip_last_(arm.T_last_tip.inverse().matrix()), ranges_(arm) {
  require_form(arm, {{0.0, kRight, 0.0, kRight},
                     {0.0, -kRight, 0.0, -kRight},
                     {0.0, kRight, {}, 0.0, true},
                     {0.0, 0.0, {}, 0.0},
                     {0.0, -kRight, 0.0, -kRight},
                     {{}, -kRight, 0.0, -kRight}});
  remote_ = -arm.joints[2].dh->d;
  shaft_ = arm.joints[3].dh->d;
  wrist_ = arm.joints[5].dh->a;
}

PsmKinematics::Joints PsmKinematics::candidate(const Eigen::Matrix4d& T, double wrist_side,
                                               double shaft_side, const Joints& near,
                                               bool& singular) const noexcept {
  const Eigen::Vector3d x6 = T.block<3, 1>(0, 0);
  const Eigen::Vector3d z6 = T.block<3, 1>(0, 2);
  const Eigen::Vector3d p6 = T.topRightCorner<3, 1>();
  const Eigen::Matrix3d R3_near = shaft_orientation(near[0], near[1]);
  const Eigen::Vector3d normal = z6.cross(p6);
  singular = normal.norm() < kSingularDistance;
  // The axis of wrist pitch, perpendicular to the plane of shaft, wrist and axis of wrist yaw.
  const Eigen::Vector3d z5 = singular ? unit_component_across(R3_near * rotation_about_z(near[3]).col(1), z6)
                                      : Eigen::Vector3d(wrist_side * normal.normalized());
  const Eigen::Vector3d x5 = z6.cross(z5);
  const Eigen::Vector3d p5 = p6 - wrist_ * x5;
  const double length = shaft_side * p5.norm();
  Eigen::Vector3d u = p5 / length;
  if (std::abs(length) < kSingularDistance) {
    singular = true;
    u = unit_component_across(R3_near.col(2), z5);
  }
  Joints q;
  shaft_angles(u, near[0], q[0], q[1], singular);
  q[2] = length + remote_ - shaft_;
  const Eigen::Matrix3d R3 = shaft_orientation(q[0], q[1]);
  const Eigen::Vector3d z5_3 = R3.transpose() * z5;
  q[3] = std::atan2(-z5_3.x(), z5_3.y());
  const Eigen::Vector3d x5_4 = rotation_about_z(q[3]).transpose() * (R3.transpose() * x5);
  q[4] = std::atan2(x5_4.x(), x5_4.z());
  q[5] = std::atan2(x6.dot(x5), x6.dot(z5));
  return q;
}

InverseSolution<6> PsmKinematics::inverse(const Eigen::Matrix4d& T_base_tip,
                                          const Joints& near) const noexcept {
  SolutionChoice<6> choice(ranges_, near);
  if (!T_base_tip.allFinite() || !near.allFinite()) return choice.best();
  const Eigen::Matrix4d T = T_base_tip * T_tip_last_;
  for (const double wrist_side : {1.0, -1.0}) {
    for (const double shaft_side : {1.0, -1.0}) {
      bool singular = false;
      const Joints q = candidate(T, wrist_side, shaft_side, near, singular);
      choice.add_candidate(q, singular);
    }
  }
  return choice.best();
}

EcmKinematics::EcmKinematics(const ArmFacts& arm) : ranges_(arm) {
  require_form(arm, {{0.0, kRight, 0.0, kRight},
                     {0.0, -kRight, 0.0, -kRight},
                     {0.0, kRight, {}, 0.0, true},
                     {0.0, 0.0, {}, 0.0}});
  require(arm.T_last_tip.matrix().isIdentity(1e-12), arm.name,
          ": found a tip behind the last row, expected none for an endoscope.");
  remote_ = -arm.joints[2].dh->d;
  shaft_ = arm.joints[3].dh->d;
}

InverseSolution<4> EcmKinematics::inverse(const Eigen::Matrix4d& T_base_tip,
                                          const Joints& near) const noexcept {
  constexpr double kMissing = 1e-6;  // [m]
  SolutionChoice<4> choice(ranges_, near);
  const Eigen::Vector3d p = T_base_tip.topRightCorner<3, 1>();
  const Eigen::Vector3d u = T_base_tip.block<3, 1>(0, 2);
  const double length = p.dot(u);
  // The negated comparison makes NaN count as out of reach.
  if (!((p - length * u).norm() <= kMissing) || !near.allFinite()) return choice.best();
  bool singular = false;
  Joints q;
  shaft_angles(u, near[0], q[0], q[1], singular);
  q[2] = length + remote_ - shaft_;
  const Eigen::Vector3d x4_3 =
      shaft_orientation(q[0], q[1]).transpose() * T_base_tip.block<3, 1>(0, 0);
  q[3] = std::atan2(x4_3.y(), x4_3.x());
  choice.add_candidate(q, singular);
  return choice.best();
}

}  // namespace veridyn::dvrk
