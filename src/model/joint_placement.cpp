#include "model/joint_placement.hpp"

#include <cmath>
#include <limits>

namespace veridyn {
namespace {

// A rotation that takes z to the unit vector, unique for each axis.
Mat3d rotation_z_to(const Vec3d& axis) {
  if (axis.z < 0.0)
    return rotation_z_to({-axis.x, -axis.y, -axis.z}) * Mat3d{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
  // Rodrigues' formula for the smallest rotation, about z x axis.
  const double x = axis.x;
  const double y = axis.y;
  const double k = 1.0 / (1.0 + axis.z);
  // clang-format off
  return {{1.0 - k * x * x,      -k * x * y, x},
          {     -k * x * y, 1.0 - k * y * y, y},
          {             -x,              -y, axis.z}};
  // clang-format on
}

// Rotation by an angle about a unit vector (Rodrigues).
Mat3d rotation_about(const Vec3d& u, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const double k = 1.0 - c;
  // clang-format off
  return {{c + k * u.x * u.x,       k * u.x * u.y - s * u.z, k * u.x * u.z + s * u.y},
          {k * u.y * u.x + s * u.z, c + k * u.y * u.y,       k * u.y * u.z - s * u.x},
          {k * u.z * u.x - s * u.y, k * u.z * u.y + s * u.x, c + k * u.z * u.z}};
  // clang-format on
}

}  // namespace

Mat3d rotation_from_rpy(const Vec3d& rpy) {
  return rotation_z(rpy.z) * rotation_y(rpy.y) * rotation_x(rpy.x);
}

Vec3d rpy_from_rotation(const Mat3d& R) {
  // Pitch and roll follow from Rz(-yaw) R for any choice of yaw, so that no accuracy is lost near pitch =
  // +-pi/2.
  constexpr double kNoise = 4.0 * std::numeric_limits<double>::epsilon();
  const bool upright = std::hypot(R.row0.x, R.row1.x) < kNoise;
  const double yaw = upright ? 0.0 : std::atan2(R.row1.x, R.row0.x);
  const Mat3d Q = rotation_z(-yaw) * R;
  return {std::atan2(-Q.row1.z, Q.row1.y), std::atan2(-Q.row2.x, Q.row0.x), yaw};
}

void place(Frame& frame, const JointPlacement& placement) {
  if (frame.type == JointType::kFixed) {
    frame.A = placement.origin * Posed{identity3(), placement.tip};
    frame.B = identity_pose();
    return;
  }
  const Mat3d R_joint_z = rotation_z_to(placement.axis);
  frame.A = placement.origin * Posed{R_joint_z, {0, 0, 0}};
  frame.B = {transpose(R_joint_z), rotate_back(R_joint_z, placement.tip)};
}

JointPlacement joint_placement(const Frame& frame) {
  if (frame.type == JointType::kFixed) return {frame.A * frame.B, {0, 0, 1}, {0, 0, 0}};
  // A J B = (A B.R) (B.R' J B.R) (B.R' B.p): in this form the joint's frame has the orientation of the frame at
  // s = 0.
  return {{frame.A.R * frame.B.R, frame.A.p}, frame.B.R.row2, rotate_back(frame.B.R, frame.B.p)};
}

JointPlacement joint_placement_with_offset(const Frame& frame) {
  JointPlacement placed = joint_placement(frame);
  if (frame.type == JointType::kFixed) return placed;
  const bool turns = frame.type == JointType::kRevolute;
  const double s0 = frame.variable.offset;
  const Vec3d& u = placed.axis;
  if (s0 != 0.0 && turns) placed.origin.R = placed.origin.R * rotation_about(u, s0);
  // A translation along the axis commutes with a rotation about it, and every translation with a
  // slide.
  const double along = dot(u, placed.tip);
  const Vec3d part = turns ? along * u : placed.tip + s0 * u;
  placed.origin = placed.origin * Posed{identity3(), part};
  placed.tip = turns ? placed.tip + (-along) * u : Vec3d{0, 0, 0};
  const double noise = 1e-16 * (1.0 + std::abs(along));
  if (dot(placed.tip, placed.tip) < noise * noise) placed.tip = {0, 0, 0};
  return placed;
}

}  // namespace veridyn
