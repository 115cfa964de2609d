#pragma once

#include "veridyn/model/model.hpp"

namespace veridyn {

/// Roll, pitch, yaw [rad]: R = Rz(yaw) Ry(pitch) Rx(roll), as in URDF.
Mat3d rotation_from_rpy(const Vec3d& rpy);

/// Roll, pitch, yaw [rad] of R; yaw is 0 where pitch is +-pi/2.
Vec3d rpy_from_rotation(const Mat3d& R);

/// Placement of a frame that turns about, or slides along, any line, as in URDF:
///
///   T_parent_frame = origin * J(s about axis) * Trans(tip)
struct JointPlacement {
  Posed origin = identity_pose();  ///< T_parent_joint
  Vec3d axis{0, 0, 1};             ///< unit vector in the joint's frame
  Vec3d tip{0, 0, 0};  ///< [m] origin of the frame in the joint's frame at s = 0; zero in URDF
};

/// Sets the constant parts A and B of a frame; its type must be set.
void place(Frame& frame, const JointPlacement& placement);

/// The placement of any frame, also of one from a DH row. The offset of s is kept.
JointPlacement joint_placement(const Frame& frame);

/// joint_placement() with the offset of s, and as much of the tip as possible, moved into the origin.
JointPlacement joint_placement_with_offset(const Frame& frame);

}  // namespace veridyn
