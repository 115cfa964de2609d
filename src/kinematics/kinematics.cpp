#include "veridyn/kinematics/kinematics.hpp"

#include "math/eigen_pose.hpp"
#include "veridyn/kinematics/point_motion.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

void check(const char* where, const Model& arm, const VectorRef& q, int frame) {
  require(q.size() == arm.joints(), where, ": q has ", q.size(), " entries, but arm '", arm.name(),
          "' has ", arm.joints(), " joints.");
  require(frame >= 0 && frame < static_cast<int>(arm.frames().size()), where, ": frame ", frame,
          " is not one of the ", arm.frames().size(), " frames of arm '", arm.name(), "'.");
}

PointMotion motion_of(const Model& arm, const VectorXd& q, const VectorXd& dq, int frame) {
  PointMotion motion(Tree(arm, Tree::Keep::kMovingLinks), frame);
  motion.update(q.data(), dq.data());
  return motion;
}

}  // namespace

Eigen::Isometry3d frame_pose(const Model& arm, const VectorRef& q, int frame) {
  check("frame_pose", arm, q, frame);
  return eigen(motion_of(arm, q, VectorXd::Zero(arm.joints()), frame).pose());
}

MatrixXd frame_jacobian(const Model& arm, const VectorRef& q, int frame) {
  check("frame_jacobian", arm, q, frame);
  return motion_of(arm, q, VectorXd::Zero(arm.joints()), frame).jacobian();
}

MatrixXd frame_jacobian_rate(const Model& arm, const VectorRef& q, const VectorRef& dq, int frame) {
  check("frame_jacobian_rate", arm, q, frame);
  require(dq.size() == arm.joints(), "frame_jacobian_rate: dq has ", dq.size(),
          " entries, but arm '", arm.name(), "' has ", arm.joints(), " joints.");
  return motion_of(arm, q, dq, frame).jacobian_rate();
}

}  // namespace veridyn
