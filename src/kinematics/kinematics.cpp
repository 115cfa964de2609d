#include "veridyn/kinematics/kinematics.hpp"

#include "kinematics/link_pose.hpp"
#include "veridyn/kinematics/recursion.hpp"
#include "veridyn/kinematics/tree.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

Eigen::Vector3d eigen(const Vec3d& a) {
  return {a.x, a.y, a.z};
}

void check(const char* where, const Model& arm, const VectorRef& q, int frame) {
  require(q.size() == arm.joints(), where, ": q has ", q.size(), " entries, but arm '", arm.name(),
          "' has ", arm.joints(), " joints.");
  require(frame >= 0 && frame < static_cast<int>(arm.frames().size()), where, ": frame ", frame,
          " is not one of the ", arm.frames().size(), " frames of arm '", arm.name(), "'.");
}

}  // namespace

Eigen::Isometry3d frame_pose(const Model& arm, const VectorRef& q, int frame) {
  check("frame_pose", arm, q, frame);
  const Tree tree(arm, Tree::Keep::kEveryFrame);
  Recursion<double> r(tree);
  const VectorXd rest = VectorXd::Zero(arm.joints());
  const VectorXd at = q;
  forward_pass(tree, at.data(), rest.data(), rest.data(), {0, 0, 0}, r);
  const Posed T = link_pose(tree, r, tree.link_of_frame[frame]);
  Eigen::Isometry3d pose;
  // clang-format off
  pose.matrix() << T.R.row0.x, T.R.row0.y, T.R.row0.z, T.p.x,
                   T.R.row1.x, T.R.row1.y, T.R.row1.z, T.p.y,
                   T.R.row2.x, T.R.row2.y, T.R.row2.z, T.p.z,
                   0, 0, 0, 1;
  // clang-format on
  return pose;
}

MatrixXd frame_jacobian(const Model& arm, const VectorRef& q, int frame) {
  check("frame_jacobian", arm, q, frame);
  const Tree tree(arm, Tree::Keep::kEveryFrame);
  Recursion<double> r(tree);
  const VectorXd rest = VectorXd::Zero(arm.joints());
  const VectorXd at = q;
  forward_pass(tree, at.data(), rest.data(), rest.data(), {0, 0, 0}, r);
  jacobian_pass(tree, r);
  const int link = tree.link_of_frame[frame];
  const Mat3d R_world_link = link_pose(tree, r, link).R;
  MatrixXd J = MatrixXd::Zero(6, arm.joints());
  for (int m = tree.links[link].first_support; m < tree.links[link].end_support; ++m) {
    const int i = tree.supports[m].coordinate;
    const Column<double>& c = r.jacobian[m];
    J.block<3, 1>(0, i) = eigen(rotate(R_world_link, c.v));
    J.block<3, 1>(3, i) = eigen(rotate(R_world_link, c.w));
  }
  return J;
}

MatrixXd frame_jacobian_rate(const Model& arm, const VectorRef& q, const VectorRef& dq, int frame) {
  check("frame_jacobian_rate", arm, q, frame);
  require(dq.size() == arm.joints(), "frame_jacobian_rate: dq has ", dq.size(),
          " entries, but arm '", arm.name(), "' has ", arm.joints(), " joints.");
  const Tree tree(arm, Tree::Keep::kEveryFrame);
  Recursion<double> r(tree);
  const VectorXd rest = VectorXd::Zero(arm.joints());
  const VectorXd at = q;
  const VectorXd rate = dq;
  forward_pass(tree, at.data(), rate.data(), rest.data(), {0, 0, 0}, r);
  jacobian_pass(tree, r);
  jacobian_rate_pass(tree, r);
  const int link = tree.link_of_frame[frame];
  const Mat3d R_world_link = link_pose(tree, r, link).R;
  const Vec3d omega = r.link[link].omega;
  MatrixXd dJ = MatrixXd::Zero(6, arm.joints());
  for (int m = tree.links[link].first_support; m < tree.links[link].end_support; ++m) {
    // d(R c)/dt = R (dc/dt + omega x c), omega and c in the link's frame.
    const int i = tree.supports[m].coordinate;
    const Column<double>& c = r.jacobian[m];
    const Column<double>& rate_i = r.jacobian_rate[m];
    dJ.block<3, 1>(0, i) = eigen(rotate(R_world_link, rate_i.v + cross(omega, c.v)));
    dJ.block<3, 1>(3, i) = eigen(rotate(R_world_link, rate_i.w + cross(omega, c.w)));
  }
  return dJ;
}

}  // namespace veridyn
