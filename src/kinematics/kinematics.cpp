#include "veridyn/kinematics/kinematics.hpp"

#include "math/eigen_pose.hpp"
#include "veridyn/kinematics/point_motion.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// Throws InvalidInput if q has another size or the frame does not exist.
void check(const char* where, const Model& arm, const VectorRef& q, FrameIndex frame) {
  require(q.size() == arm.joints(), where, ": q has ", q.size(), " entries, but arm '", arm.name(),
          "' has ", arm.joints(), " joints.");
  require(frame.value >= 0 && frame.value < static_cast<int>(arm.frames().size()), where, ": frame ", frame.value,
          " is not one of the ", arm.frames().size(), " frames of arm '", arm.name(), "'.");
}

PointMotion point(const Model& arm, FrameIndex frame) {
  return PointMotion(Tree(arm, Tree::Keep::kMovingLinks), frame);
}

}  // namespace

Eigen::Isometry3d frame_pose(const Model& arm, const VectorRef& q, FrameIndex frame) {
  check("frame_pose", arm, q, frame);
  PointMotion motion = point(arm, frame);
  const VectorXd stored = q;
  motion.place(stored.data());
  return eigen(motion.pose());
}

MatrixXd frame_jacobian(const Model& arm, const VectorRef& q, FrameIndex frame) {
  check("frame_jacobian", arm, q, frame);
  PointMotion motion = point(arm, frame);
  const VectorXd stored = q;
  motion.update(stored.data());
  return motion.jacobian();
}

MatrixXd frame_jacobian_rate(const Model& arm, const VectorRef& q, const VectorRef& dq, FrameIndex frame) {
  check("frame_jacobian_rate", arm, q, frame);
  require(dq.size() == arm.joints(), "frame_jacobian_rate: dq has ", dq.size(),
          " entries, but arm '", arm.name(), "' has ", arm.joints(), " joints.");
  PointMotion motion = point(arm, frame);
  const VectorXd stored = q, rates = dq;
  motion.update(stored.data(), rates.data());
  return motion.jacobian_rate();
}

}  // namespace veridyn
