#include "simulation/world/arm_points.hpp"

#include "veridyn/math/eigen_pose.hpp"

namespace veridyn {
namespace {

Vec3d point_acceleration(const Column<double>& c, const Vec3d& offset) {
  return c.v + cross(c.w, offset);
}

}  // namespace

ArmPoints::ArmPoints(const Model& arm, const Posed& T_world_base)
    : tree_(arm, Tree::Keep::kEveryFrame),
      recursion_(tree_),
      base_(T_world_base),
      dq_(VectorXd::Zero(arm.joints())),
      T_world_(tree_.links.size(), identity_pose()) {
  move_to(dq_, dq_);
}

void ArmPoints::move_to(const VectorXd& q, const VectorXd& dq) noexcept {
  joint_pass<double>(tree_, q.data(), nullptr, nullptr, recursion_);
  dq_ = dq;
  jacobian_pass<double>(tree_, recursion_);
  for (size_t k = 0; k < tree_.links.size(); ++k) {
    const Link& link = tree_.links[k];
    Posed J = identity_pose();
    if (link.type == JointType::kRevolute) J.R = rotation_z(recursion_.link[k].s);
    if (link.type == JointType::kPrismatic) J.p.z = recursion_.link[k].s;
    const Posed& above = link.parent < 0 ? base_ : T_world_[link.parent];
    T_world_[k] = above * link.A * J * link.B;
  }
}

ArmPoints::Point ArmPoints::point(int frame, const Eigen::Vector3d& offset) const noexcept {
  const auto k = static_cast<size_t>(tree_.link_of_frame[frame]);
  const Posed& T = T_world_[k];
  const Link& link = tree_.links[k];
  const Vec3d at = from_eigen(offset);
  Vec3d v{0, 0, 0};
  for (int m = link.first_support; m < link.end_support; ++m) {
    v = v + dq_[tree_.supports[m].coordinate] *
                point_acceleration(recursion_.jacobian[m], at);
  }
  return {eigen(T.p + rotate(T.R, at)), eigen(rotate(T.R, v))};
}

void ArmPoints::add_force(int frame, const Eigen::Vector3d& offset, const Eigen::Vector3d& force,
                          double share, VectorXd& tau) const noexcept {
  const auto k = static_cast<size_t>(tree_.link_of_frame[frame]);
  const Link& link = tree_.links[k];
  const Vec3d in_link = rotate_back(T_world_[k].R, from_eigen(force));
  const Vec3d at = from_eigen(offset);
  for (int m = link.first_support; m < link.end_support; ++m) {
    tau[tree_.supports[m].coordinate] +=
        share * dot(point_acceleration(recursion_.jacobian[m], at), in_link);
  }
}

void ArmPoints::jacobian(int frame, const Eigen::Vector3d& offset, MatrixXd& J) const noexcept {
  const auto k = static_cast<size_t>(tree_.link_of_frame[frame]);
  const Link& link = tree_.links[k];
  J.setZero();
  for (int m = link.first_support; m < link.end_support; ++m) {
    J.col(tree_.supports[m].coordinate) =
        eigen(rotate(T_world_[k].R, point_acceleration(recursion_.jacobian[m], from_eigen(offset))));
  }
}

}  // namespace veridyn
