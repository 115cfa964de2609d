#pragma once

#include <vector>

#include "veridyn/kinematics/links.hpp"
#include "veridyn/math/sine_cosine.hpp"

// Motion along the kinematic tree, over any scalar S: double, float, a pack of samples, a dual
// number, a number that records its own computation, or a user's type with + - * and sine_cosine().
// The vectors of a link are written in the link's own frame, at its origin.
//
// Source of the forms: Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 5.

namespace veridyn {

/// Scalar type of constants in arithmetic with S: float where S is float, so that nothing is promoted to double.
template <typename S>
struct ConstantOf {
  using type = double;
};
template <>
struct ConstantOf<float> {
  using type = float;
};

/// Constants in the scalar type of ConstantOf.
template <typename S>
inline Vec3<typename ConstantOf<S>::type> constant(const Vec3d& a) {
  using C = typename ConstantOf<S>::type;
  return {static_cast<C>(a.x), static_cast<C>(a.y), static_cast<C>(a.z)};
}

template <typename S>
inline Mat3<typename ConstantOf<S>::type> constant(const Mat3d& R) {
  return {constant<S>(R.row0), constant<S>(R.row1), constant<S>(R.row2)};
}

/// E = [alpha]x + [omega]x [omega]x by columns: E p is the acceleration of a point at p relative to the origin.
template <typename S>
struct Spin {
  Vec3<S> x, y, z;
};

template <typename S>
inline Spin<S> spin(const Vec3<S>& omega, const Vec3<S>& alpha) {
  const S xx = omega.x * omega.x;
  const S yy = omega.y * omega.y;
  const S zz = omega.z * omega.z;
  const S yz = omega.y * omega.z;
  const S xz = omega.x * omega.z;
  const S xy = omega.x * omega.y;
  // clang-format off
  return {{-(yy + zz), xy + alpha.z, xz - alpha.y},
          {xy - alpha.z, -(xx + zz), yz + alpha.x},
          {xz + alpha.y, yz - alpha.x, -(xx + yy)}};
  // clang-format on
}

/// The product E p.
template <typename S, typename C>
inline Vec3<S> apply(const Spin<S>& E, const Vec3<C>& p) {
  return p.x * E.x + p.y * E.y + p.z * E.z;
}

template <typename S>
struct LinkState {
  S s, ds, dds;      ///< joint variable and its derivatives
  S sine, cosine;    ///< sine and cosine of s; only where the joint is revolute
  Mat3<S> R;         ///< R_parent_joint
  Vec3<S> omega;     ///< angular velocity
  Vec3<S> alpha;     ///< angular acceleration
  Vec3<S> accel;     ///< acceleration of the origin, minus gravity
  Spin<S> E;         ///< spin matrix of omega and alpha
  Vec3<S> force;     ///< force and moment that move the link and all that it carries
  Vec3<S> moment;
};

/// Angular and linear velocity of a link per unit of one coordinate's velocity.
template <typename S>
struct Column {
  Vec3<S> w, v;
};

/// Arrays that the passes write; links.hpp gives the reason for plain arrays.
template <typename S>
struct Workspace {
  LinkState<S>* link;   ///< one per link
  Column<S>* jacobian;  ///< one per supporting coordinate
};

/// A workspace with its memory; it is sized once and reused.
template <typename S>
struct Recursion {
  explicit Recursion(const Links& tree)
      : link(static_cast<size_t>(tree.count)), jacobian(static_cast<size_t>(tree.supports)) {}
  operator Workspace<S>() { return {link.data(), jacobian.data()}; }  // NOLINT: a view

  std::vector<LinkState<S>> link;
  std::vector<Column<S>> jacobian;
};

namespace recursion_detail {

template <typename S>
inline Vec3<S> zero3() {
  return {S(0.0), S(0.0), S(0.0)};
}

/// Transforms omega, alpha and accel across the fixed pose T (Featherstone's motion transform X).
template <typename S>
inline void transform_motion(const Posed& T, Vec3<S>& omega, Vec3<S>& alpha, Vec3<S>& accel) {
  const auto p = constant<S>(T.p);
  const auto R = constant<S>(T.R);
  const Vec3<S> swept = cross(omega, p);
  accel = rotate_back(R, accel + cross(alpha, p) + cross(omega, swept));
  omega = rotate_back(R, omega);
  alpha = rotate_back(R, alpha);
}

/// Transforms one column of a Jacobian across the fixed pose T.
template <typename S>
inline void transform_motion(const Posed& T, Vec3<S>& w, Vec3<S>& v) {
  const auto R = constant<S>(T.R);
  v = rotate_back(R, v + cross(w, constant<S>(T.p)));
  w = rotate_back(R, w);
}

}  // namespace recursion_detail

/// The product c . x over the coordinates of one link's joint variable.
template <typename S>
inline S along_joint(const Links& tree, const Link& link, const S* x) {
  using C = typename ConstantOf<S>::type;
  S sum(0.0);
  for (int e = link.first_coefficient; e < link.end_coefficient; ++e)
    sum += static_cast<C>(tree.coefficient[e].coefficient) * x[tree.coefficient[e].coordinate];
  return sum;
}

/// Computes R_parent_joint from the sine and cosine in the link's state.
template <typename S>
inline void rotation_step(const Link& link, LinkState<S>& at) {
  const auto A = constant<S>(link.A.R);
  if (link.type != JointType::kRevolute) {
    at.R = {{S(A.row0.x), S(A.row0.y), S(A.row0.z)},
            {S(A.row1.x), S(A.row1.y), S(A.row1.z)},
            {S(A.row2.x), S(A.row2.y), S(A.row2.z)}};
    return;
  }
  const S& c = at.cosine;
  const S& s = at.sine;
  if (link.quarter_turn) {
    const S none(0.0);
    at.R = {{c, -s, none}, {none, none, S(A.row1.z)}, {A.row2.y * s, A.row2.y * c, none}};
    return;
  }
  at.R = {{A.row0.x * c + A.row0.y * s, A.row0.y * c - A.row0.x * s, S(A.row0.z)},
          {A.row1.x * c + A.row1.y * s, A.row1.y * c - A.row1.x * s, S(A.row1.z)},
          {A.row2.x * c + A.row2.y * s, A.row2.y * c - A.row2.x * s, S(A.row2.z)}};
}

/// The product R' a, which changes from the axes of the parent to those of the joint. If A is a quarter turn,
/// five products suffice.
template <typename S, typename V>
inline Vec3<V> to_joint(const Link& link, const Mat3<S>& R, const Vec3<V>& a) {
  if (!link.quarter_turn) return rotate_back(R, a);
  return {R.row0.x * a.x + R.row2.x * a.z, R.row0.y * a.x + R.row2.y * a.z, R.row1.z * a.y};
}

/// The product R a, which changes from the axes of the joint to those of the parent.
template <typename S, typename V>
inline Vec3<V> from_joint(const Link& link, const Mat3<S>& R, const Vec3<V>& a) {
  if (!link.quarter_turn) return rotate(R, a);
  return {R.row0.x * a.x + R.row0.y * a.y, R.row1.z * a.z, R.row2.x * a.x + R.row2.y * a.y};
}

/// Computes velocity, acceleration and E of link k from its parent's; needs joint_pass().
template <typename S>
inline void forward_step(const Links& tree, int k, const Vec3d& gravity, const Workspace<S>& r) {
  namespace d = recursion_detail;
  const Link& link = tree.link[k];
  LinkState<S>& at = r.link[k];
  Vec3<S> omega = d::zero3<S>();
  Vec3<S> alpha = d::zero3<S>();
  Vec3<S> accel;
  if (link.parent >= 0) {
    const LinkState<S>& above = r.link[link.parent];
    omega = to_joint(link, at.R, above.omega);
    alpha = to_joint(link, at.R, above.alpha);
    accel = above.accel;
    if (link.A_moves) accel = accel + apply(above.E, constant<S>(link.A.p));
    accel = to_joint(link, at.R, accel);
  } else {
    accel = rotate_back(at.R, constant<S>(Vec3d{-gravity.x, -gravity.y, -gravity.z}));
  }
  if (link.type == JointType::kRevolute) {
    alpha.x += omega.y * at.ds;  // omega_parent x z ds
    alpha.y -= omega.x * at.ds;
    alpha.z += at.dds;
    omega.z += at.ds;
  }
  at.E = spin(omega, alpha);
  if (link.type == JointType::kPrismatic) {
    const S twice = at.ds + at.ds;
    accel = accel + at.s * at.E.z;
    accel.x += omega.y * twice;  // 2 omega x z ds
    accel.y -= omega.x * twice;
    accel.z += at.dds;
  }
  if (!link.B_is_identity) {
    d::transform_motion(link.B, omega, alpha, accel);
    at.E = spin(omega, alpha);
  }
  at.omega = omega;
  at.alpha = alpha;
  at.accel = accel;
}

/// Computes one link's joint variable and its derivatives; a null dq or ddq counts as zeros.
template <typename S>
inline void joint_variable(const Links& tree, const Link& link, const S* q, const S* dq, const S* ddq,
                           LinkState<S>& at) {
  at.s = along_joint(tree, link, q) + S(static_cast<typename ConstantOf<S>::type>(link.offset));
  at.ds = dq == nullptr ? S(0.0) : along_joint(tree, link, dq);
  at.dds = ddq == nullptr ? S(0.0) : along_joint(tree, link, ddq);
}

/// Computes joint variables and rotations of all links. @param q, dq, ddq  n entries each.
template <typename S>
inline void joint_pass(const Links& tree, const S* q, const S* dq, const S* ddq,
                       const Workspace<S>& r) {
  for (int k = 0; k < tree.count; ++k) {
    const Link& link = tree.link[k];
    LinkState<S>& at = r.link[k];
    joint_variable(tree, link, q, dq, ddq, at);
    if (link.type == JointType::kRevolute) sine_cosine(at.s, at.sine, at.cosine);
    rotation_step(link, at);
  }
}

/// Transforms one column of the parent's Jacobian, or several side by side, to the link's joint, so
/// that it describes a motion of the parent with the joint held.
template <typename S, typename L>
inline Column<L> to_joint(const Link& link, const LinkState<S>& at, const Column<L>& above) {
  Vec3<L> v = above.v;
  if (link.A_moves) v = v + cross(above.w, constant<S>(link.A.p));
  Column<L> c{to_joint(link, at.R, above.w), to_joint(link, at.R, v)};
  if (link.type == JointType::kPrismatic) {
    c.v.x += at.s * c.w.y;
    c.v.y -= at.s * c.w.x;
  }
  return c;
}

/// Computes the body Jacobian of one link from its parent's.
template <typename S>
inline void jacobian_step(const Links& tree, int k, const Workspace<S>& r) {
  namespace d = recursion_detail;
  using C = typename ConstantOf<S>::type;
  const Link& link = tree.link[k];
  for (int m = link.first_support; m < link.end_support; ++m) {
    const SupportingCoordinate& i = tree.support[m];
    Column<S> c{d::zero3<S>(), d::zero3<S>()};
    if (i.parent_entry >= 0) c = to_joint(link, r.link[k], r.jacobian[i.parent_entry]);
    const S own(static_cast<C>(i.coefficient));
    if (i.coefficient != 0.0 && link.type == JointType::kRevolute) c.w.z += own;
    if (i.coefficient != 0.0 && link.type == JointType::kPrismatic) c.v.z += own;
    if (!link.B_is_identity) d::transform_motion(link.B, c.w, c.v);
    r.jacobian[m] = c;
  }
}

/// Computes the body Jacobians of all links; requires joint_pass() at the same q.
template <typename S>
inline void jacobian_pass(const Links& tree, const Workspace<S>& r) {
  for (int k = 0; k < tree.count; ++k) jacobian_step(tree, k, r);
}

}  // namespace veridyn
