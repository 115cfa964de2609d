#include "veridyn/kinematics/point_motion.hpp"

#include <algorithm>

#include "veridyn/kinematics/recursion.hpp"

namespace veridyn {
namespace {

// R times the rotation about z.
Mat3d turned(const Mat3d& R, double sine, double cosine) {
  const auto row = [&](const Vec3d& r) {
    return Vec3d{r.x * cosine + r.y * sine, r.y * cosine - r.x * sine, r.z};
  };
  return {row(R.row0), row(R.row1), row(R.row2)};
}

void add(double share, const Vec3d& linear, const Vec3d& angular, double* column) {
  column[0] += share * linear.x;
  column[1] += share * linear.y;
  column[2] += share * linear.z;
  column[3] += share * angular.x;
  column[4] += share * angular.y;
  column[5] += share * angular.z;
}

}  // namespace

PointMotion::PointMotion(const Tree& arm, int frame, const Vec3d& offset)
    : tree_(arm),
      T_link_point_(arm.frames[frame].T_link_body * Posed{identity3(), offset}),
      J_(MatrixXd::Zero(6, arm.joints)),
      dJ_(J_) {
  for (int k = arm.frames[frame].link; k >= 0; k = arm.links[k].parent) axes_.push_back({k, {}, {}, {}, {}});
  std::reverse(axes_.begin(), axes_.end());
}

void PointMotion::update(const double* q, const double* dq) noexcept {
  const Links tree = tree_;
  T_ = identity_pose();
  v_ = omega_ = {0, 0, 0};
  const auto move_along = [this](const Vec3d& r) {
    T_.p = T_.p + r;
    v_ = v_ + cross(omega_, r);
  };
  for (Axis& axis : axes_) {
    const Link& link = tree.link[axis.link];
    const double s = along_joint(tree, link, q) + link.offset;
    const double ds = along_joint(tree, link, dq);
    if (link.A_moves) move_along(rotate(T_.R, link.A.p));
    T_.R = T_.R * link.A.R;
    axis.z = {T_.R.row0.z, T_.R.row1.z, T_.R.row2.z};
    axis.dz = cross(omega_, axis.z);
    axis.p = T_.p;
    axis.dp = v_;
    if (link.type == JointType::kRevolute) {
      double sine, cosine;
      sine_cosine(s, sine, cosine);
      T_.R = turned(T_.R, sine, cosine);
      omega_ = omega_ + ds * axis.z;
    } else {
      move_along(s * axis.z);
      v_ = v_ + ds * axis.z;
    }
  }
  move_along(rotate(T_.R, T_link_point_.p));
  T_.R = T_.R * T_link_point_.R;
  J_.setZero();
  dJ_.setZero();
  const Vec3d none{0, 0, 0};
  for (const Axis& axis : axes_) {
    const Link& link = tree.link[axis.link];
    const bool turns = link.type == JointType::kRevolute;
    const Vec3d r = T_.p - axis.p;
    const Vec3d linear = turns ? cross(axis.z, r) : axis.z;
    const Vec3d rate = turns ? cross(axis.dz, r) + cross(axis.z, v_ - axis.dp) : axis.dz;
    for (int e = link.first_coefficient; e < link.end_coefficient; ++e) {
      const JointCoefficient& c = tree.coefficient[e];
      add(c.coefficient, linear, turns ? axis.z : none, J_.data() + 6 * c.coordinate);
      add(c.coefficient, rate, turns ? axis.dz : none, dJ_.data() + 6 * c.coordinate);
    }
  }
}

}  // namespace veridyn
