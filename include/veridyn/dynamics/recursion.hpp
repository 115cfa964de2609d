#pragma once

#include "veridyn/dynamics/link_inertia.hpp"
#include "veridyn/kinematics/recursion.hpp"

// Forces along the kinematic tree, over any scalar S. Functions that take inertias require a tree of
// moving links (Tree::Keep::kMovingLinks).
//
// Source of the forms: Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 5; regressor:
// Atkeson, An and Hollerbach, IJRR 5(3), 1986.

namespace veridyn {

/// Terms of one body's motion that its regressor entries share, for all coordinates that move it.
template <typename S>
struct BodyMotion {
  Vec3<S> accel, alpha;
  Spin<S> E;
  Vec3<S> products;     ///< omega_y omega_z, omega_x omega_z, omega_x omega_y
  Vec3<S> differences;  ///< omega_y^2 - omega_z^2, omega_z^2 - omega_x^2, omega_x^2 - omega_y^2
};

/// The motion of a body whose frame is that of its link.
template <typename S>
inline BodyMotion<S> body_motion(const LinkState<S>& at) {
  const Vec3<S>& alpha = at.alpha;
  const Spin<S>& E = at.E;
  return {at.accel, alpha, E,
          {E.z.y + alpha.x, E.x.z + alpha.y, E.y.x + alpha.z},
          {E.y.y - E.z.z, E.z.z - E.x.x, E.x.x - E.y.y}};
}

/// The motion of a body whose frame is not that of its link.
template <typename S>
inline BodyMotion<S> body_motion(const LinkState<S>& at, const BodyPlace& place) {
  if (place.is_identity) return body_motion(at);
  LinkState<S> moved;
  moved.omega = at.omega;
  moved.alpha = at.alpha;
  moved.accel = at.accel;
  recursion_detail::transform_motion(place.T_link_body, moved.omega, moved.alpha, moved.accel);
  moved.E = spin(moved.omega, moved.alpha);
  return body_motion(moved);
}

/// The ten entries of the regressor that belong to one body and one coordinate, or to several side
/// by side, tau_i = w_i . n + v_i . f; needs forward_step() and jacobian_pass(). Order:
/// InertialParameters.
///
/// @param put  called as put(k, entry) for k = 0 .. 9, so that the caller stores each entry
/// straight from registers.
template <typename S, typename L, typename Put>
inline void regressor_entries(const BodyMotion<S>& b, const Column<L>& c, const Put& put) {
  const Vec3<L>& w = c.w;
  const Vec3<L> turned = cross(b.accel, w);  // w . (h x a) = h . (a x w)
  put(0, dot(c.v, b.accel));
  put(1, dot(c.v, b.E.x) + turned.x);
  put(2, dot(c.v, b.E.y) + turned.y);
  put(3, dot(c.v, b.E.z) + turned.z);
  put(4, w.x * b.alpha.x + w.y * b.products.y - w.z * b.products.z);
  put(5, w.y * b.E.y.z - w.x * b.E.x.z + w.z * b.differences.z);
  put(6, w.y * b.alpha.y + w.z * b.products.z - w.x * b.products.x);
  put(7, w.x * b.E.x.y - w.z * b.E.z.y + w.y * b.differences.y);
  put(8, w.z * b.E.z.x - w.y * b.E.y.x + w.x * b.differences.x);
  put(9, w.z * b.alpha.z + w.x * b.products.x - w.y * b.products.y);
}

/// Force and moment that a link needs for its own motion, if I has the zeros of link_inertias(). They are linear in accel and E, so that the
/// derivatives of accel and E in their place give the derivatives of force and moment.
template <typename S>
inline void link_wrench(const Link& link, const LinkInertia& I, const Vec3<S>& accel,
                        const Spin<S>& E, Vec3<S>& force, Vec3<S>& moment) {
  using C = typename ConstantOf<S>::type;
  const auto c = [](double x) { return static_cast<C>(x); };
  if (link.type == JointType::kPrismatic) {
    const auto h = constant<S>(I.h);
    force = c(I.m) * accel + apply(E, h);
    moment = cross(h, accel);
    return;
  }
  const C hx = c(I.h.x), hy = c(I.h.y);
  const C xx = c(I.xx), xy = c(I.xy), yy = c(I.yy), xz = c(I.xz), yz = c(I.yz);
  force = hx * E.x + hy * E.y;
  // The sum of x x E x is the skew part of E X, where X are the second moments.
  moment = {xy * E.x.z + yy * E.y.z + yz * E.z.z - xz * E.x.y - yz * E.y.y + hy * accel.z,
            xz * E.x.x + yz * E.y.x - xx * E.x.z - xy * E.y.z - xz * E.z.z - hx * accel.z,
            xx * E.x.y + xy * E.y.y + xz * E.z.y - xy * E.x.x - yy * E.y.x - yz * E.z.x +
                hx * accel.y - hy * accel.x};
}

namespace recursion_detail {

/// Adds force and moment at a joint's origin, in its axes, to those of the parent, at the parent's origin and in its axes.
template <typename S, typename L>
inline void to_parent(const Link& link, const Mat3<S>& R, const Vec3<L>& force,
                      const Vec3<L>& moment, Vec3<L>& parent_force, Vec3<L>& parent_moment) {
  const Vec3<L> f = from_joint(link, R, force);
  parent_force = parent_force + f;
  parent_moment = parent_moment + from_joint(link, R, moment);
  if (link.A_moves) parent_moment = parent_moment + cross(constant<S>(link.A.p), f);
}

}  // namespace recursion_detail

/// Moves the wrench (or momentum) in a link's state to the parent's frame and adds it there.
template <typename S>
inline void carry_force(const Link& link, const LinkState<S>& at, LinkState<S>& parent) {
  Vec3<S> moment = at.moment;
  if (link.type == JointType::kPrismatic) {  // (s z) x force
    moment.x -= at.s * at.force.y;
    moment.y += at.s * at.force.x;
  }
  recursion_detail::to_parent(link, at.R, at.force, moment, parent.force, parent.moment);
}

/// Projects the links' forces onto the joints; the force in a link's state becomes the sum over all
/// links that it carries.
///
/// @param tau  n entries, overwritten.
template <typename S>
inline void backward_pass(const Links& tree, const Workspace<S>& r, S* tau) {
  using C = typename ConstantOf<S>::type;
  for (int i = 0; i < tree.joints; ++i) tau[i] = S(0.0);
  for (int k = tree.count - 1; k >= 0; --k) {
    const Link& link = tree.link[k];
    const LinkState<S>& at = r.link[k];
    const S& effort = link.type == JointType::kRevolute ? at.moment.z : at.force.z;
    for (int e = link.first_coefficient; e < link.end_coefficient; ++e) {
      const JointCoefficient& c = tree.coefficient[e];
      tau[c.coordinate] += static_cast<C>(c.coefficient) * effort;
    }
    if (link.parent >= 0) carry_force(link, at, r.link[link.parent]);
  }
}

}  // namespace veridyn
