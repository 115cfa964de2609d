#include "veridyn/kinematics/point_motion.hpp"

#include <algorithm>
#include <cmath>

#include "math/pack.hpp"
#include "veridyn/kinematics/recursion.hpp"

namespace veridyn {
namespace {

struct Here;
using Angles = Pack<2, Here>;        // the widest vectors that every processor of the architecture has
constexpr double kQuickAngle = 1e5;  // [rad]; the fast approximation loses digits beyond it

// The product R A; if A is a quarter turn about x, columns are swapped.
Mat3d turned(const Mat3d& R, const Link& link) {
  if (!link.quarter_turn) return R * link.A.R;
  const auto row = [&](const Vec3d& r) {
    return Vec3d{r.x, link.A.R.row2.y * r.z, link.A.R.row1.z * r.y};
  };
  return {row(R.row0), row(R.row1), row(R.row2)};
}

// R times the rotation about z.
Mat3d turned(const Mat3d& R, double sine, double cosine) {
  const auto row = [&](const Vec3d& r) {
    return Vec3d{r.x * cosine + r.y * sine, r.y * cosine - r.x * sine, r.z};
  };
  return {row(R.row0), row(R.row1), row(R.row2)};
}

}  // namespace

PointMotion::PointMotion(const Tree& arm, FrameIndex frame, const Vec3d& offset)
    : tree_(arm),
      T_link_point_(arm.frames[frame.value].T_link_body * Posed{identity3(), offset}),
      J_(MatrixXd::Zero(6, arm.joints)),
      dJ_(J_) {
  for (int k = arm.frames[frame.value].link; k >= 0; k = arm.links[k].parent)
    axes_.push_back({arm.links[k], {}, {}});
  std::reverse(axes_.begin(), axes_.end());
  for (std::vector<double>* v : {&angle_, &sine_, &cosine_}) v->assign(axes_.size() + Angles::kSize, 0.0);
}

void PointMotion::place(const double* q) noexcept {
  const Links tree = tree_;
  for (size_t k = 0; k < axes_.size(); ++k)
    angle_[k] = along_joint(tree, axes_[k].link, q) + axes_[k].link.offset;
  for (size_t k = 0; k < axes_.size(); k += Angles::kSize) {
    Angles angle, sine, cosine;
    load_lanes(&angle_[k], angle);
    sine_cosine(angle, sine, cosine);
    store_lanes(sine, Angles::kSize, &sine_[k]);
    store_lanes(cosine, Angles::kSize, &cosine_[k]);
  }
  T_ = identity_pose();
  for (size_t k = 0; k < axes_.size(); ++k) {
    Axis& axis = axes_[k];
    const Link& link = axis.link;
    if (link.A_moves) T_.p = T_.p + rotate(T_.R, link.A.p);
    T_.R = turned(T_.R, link);
    axis.z = {T_.R.row0.z, T_.R.row1.z, T_.R.row2.z};
    axis.p = T_.p;
    if (link.type != JointType::kRevolute) {
      T_.p = T_.p + angle_[k] * axis.z;
    } else if (std::abs(angle_[k]) < kQuickAngle) {
      T_.R = turned(T_.R, sine_[k], cosine_[k]);
    } else {
      T_.R = turned(T_.R, std::sin(angle_[k]), std::cos(angle_[k]));
    }
  }
  T_ = T_ * T_link_point_;
}

void PointMotion::add(const Axis& axis, const Vec3d& linear, const Vec3d& angular,
                      MatrixXd& to) const {
  for (int e = axis.link.first_coefficient; e < axis.link.end_coefficient; ++e) {
    const JointCoefficient& c = tree_.coefficients[e];
    double* const column = to.data() + 6 * c.coordinate;
    column[0] += c.coefficient * linear.x;
    column[1] += c.coefficient * linear.y;
    column[2] += c.coefficient * linear.z;
    column[3] += c.coefficient * angular.x;
    column[4] += c.coefficient * angular.y;
    column[5] += c.coefficient * angular.z;
  }
}

void PointMotion::update(const double* q) noexcept {
  place(q);
  J_.setZero();
  for (const Axis& axis : axes_) {
    const bool turns = axis.link.type == JointType::kRevolute;
    add(axis, turns ? cross(axis.z, T_.p - axis.p) : axis.z, turns ? axis.z : Vec3d{0, 0, 0}, J_);
  }
}

void PointMotion::update(const double* q, const double* dq) noexcept {
  update(q);
  const Links tree = tree_;
  v_ = omega_ = {0, 0, 0};
  Vec3d from{0, 0, 0};  // point to which the velocity v_ belongs
  const auto move_to = [&](const Vec3d& p) {
    v_ = v_ + cross(omega_, p - from);
    from = p;
  };
  // Computes the point's velocity v_; in the second loop v_ - v is its velocity relative to a point on the axis.
  for (const Axis& axis : axes_) {
    const double ds = along_joint(tree, axis.link, dq);
    move_to(axis.p);
    if (axis.link.type == JointType::kRevolute) {
      omega_ = omega_ + ds * axis.z;
    } else {
      v_ = v_ + ds * axis.z;
    }
  }
  move_to(T_.p);
  dJ_.setZero();
  Vec3d omega{0, 0, 0}, v{0, 0, 0};
  from = {0, 0, 0};
  for (const Axis& axis : axes_) {
    const double ds = along_joint(tree, axis.link, dq);
    const bool turns = axis.link.type == JointType::kRevolute;
    v = v + cross(omega, axis.p - from);
    from = axis.p;
    const Vec3d dz = cross(omega, axis.z);
    add(axis, turns ? cross(dz, T_.p - axis.p) + cross(axis.z, v_ - v) : dz,
        turns ? dz : Vec3d{0, 0, 0}, dJ_);
    (turns ? omega : v) = (turns ? omega : v) + ds * axis.z;
  }
}

}  // namespace veridyn
