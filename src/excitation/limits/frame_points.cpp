#include "excitation/limits/frame_points.hpp"

#include <Eigen/Geometry>

#include "math/eigen_pose.hpp"

namespace veridyn {

FramePoints::FramePoints(const Model& arm)
    : tree_(arm, Tree::Keep::kEveryFrame),
      recursion_(tree_),
      T_world_(tree_.links.size(), identity_pose()) {}

void FramePoints::move_to(const VectorXd& q) {
  joint_pass<double>(tree_, q.data(), nullptr, nullptr, recursion_);
  jacobian_pass<double>(tree_, recursion_);
  for (size_t k = 0; k < tree_.links.size(); ++k) {
    const Link& link = tree_.links[k];
    Posed J = identity_pose();
    if (link.type == JointType::kRevolute) J.R = rotation_z(recursion_.link[k].s);
    if (link.type == JointType::kPrismatic) J.p.z = recursion_.link[k].s;
    const Posed T_parent = link.A * J * link.B;
    T_world_[k] =
        link.parent < 0 ? T_parent : T_world_[link.parent] * T_parent;
  }
}

Eigen::Vector3d FramePoints::point(std::optional<FrameIndex> frame, const Eigen::Vector3d& in_frame) const {
  if (!frame) return in_frame;
  const Posed& T = T_world_[tree_.link_of_frame[frame->value]];
  return eigen(T.p) + eigen(rotate(T.R, from_eigen(in_frame)));
}

MatrixXd FramePoints::point_slope(std::optional<FrameIndex> frame, const Eigen::Vector3d& in_frame) const {
  MatrixXd slope = MatrixXd::Zero(3, tree_.joints);
  if (!frame) return slope;
  const auto k = static_cast<size_t>(tree_.link_of_frame[frame->value]);
  const Vec3d r{in_frame.x(), in_frame.y(), in_frame.z()};
  for (int m = tree_.links[k].first_support; m < tree_.links[k].end_support; ++m) {
    const Column<double>& c = recursion_.jacobian[m];
    slope.col(tree_.supports[m].coordinate) =
        eigen(rotate(T_world_[k].R, c.v + cross(c.w, r)));
  }
  return slope;
}

Eigen::Vector3d FramePoints::z_axis(std::optional<FrameIndex> frame) const {
  return point(frame, Eigen::Vector3d::UnitZ()) - point(frame, Eigen::Vector3d::Zero());
}

MatrixXd FramePoints::z_axis_slope(std::optional<FrameIndex> frame) const {
  return point_slope(frame, Eigen::Vector3d::UnitZ()) - point_slope(frame, Eigen::Vector3d::Zero());
}

}  // namespace veridyn
