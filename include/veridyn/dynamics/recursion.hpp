#pragma once

#include "veridyn/dynamics/link_inertia.hpp"
#include "veridyn/kinematics/recursion.hpp"

// Forces along the kinematic tree, over any scalar S, and their derivatives over any L: one number,
// or lanes of several directions side by side. Functions that take inertias require a tree of
// moving links (Tree::Keep::kMovingLinks).
//
// Source of the forms: Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 5; regressor:
// Atkeson, An and Hollerbach, IJRR 5(3), 1986; derivatives: the tangents of the Newton-Euler
// recursion, of which the mass matrix and the Coriolis matrix are parts.

namespace veridyn {

/// Terms of one body's motion that its regressor entries share, for all coordinates that move it.
template <typename S>
struct BodyMotion {
  Vec3<S> accel, alpha;
  Spin<S> E;
  Vec3<S> products;     ///< omega_y omega_z, omega_x omega_z, omega_x omega_y
  Vec3<S> differences;  ///< omega_y^2 - omega_z^2, omega_z^2 - omega_x^2, omega_x^2 - omega_y^2
};

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

/// Force and moment that a link needs for its own motion. Linear in accel and E: with their
/// derivatives it gives those of force and moment.
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
  // With X the second moments: the sum of x x E x is the skew part of E X.
  moment = {xy * E.x.z + yy * E.y.z + yz * E.z.z - xz * E.x.y - yz * E.y.y + hy * accel.z,
            xz * E.x.x + yz * E.y.x - xx * E.x.z - xy * E.y.z - xz * E.z.z - hx * accel.z,
            xx * E.x.y + xy * E.y.y + xz * E.z.y - xy * E.x.x - yy * E.y.x - yz * E.z.x +
                hx * accel.y - hy * accel.x};
}

namespace recursion_detail {

/// Transforms force and moment of a link to its joint's origin, in the frame of its parent.
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

/// Adds the inertia I of a link, and of all that it carries, to that of its parent.
template <typename S>
inline void carry_inertia(const Link& link, const LinkState<S>& at, InertiaOf<S> I,
                          InertiaOf<S>& parent) {
  if (link.type == JointType::kPrismatic) {
    I.xz += at.s * I.h.x;
    I.yz += at.s * I.h.y;
    I.zz += at.s * (I.h.z + I.h.z + at.s * I.m);
    I.h.z += at.s * I.m;
  }
  // R X R': R times the columns of X, then R times the rows of that product.
  const Vec3<S> x = from_joint(link, at.R, Vec3<S>{I.xx, I.xy, I.xz});
  const Vec3<S> y = from_joint(link, at.R, Vec3<S>{I.xy, I.yy, I.yz});
  const Vec3<S> z = from_joint(link, at.R, Vec3<S>{I.xz, I.yz, I.zz});
  const Vec3<S> to_x = from_joint(link, at.R, Vec3<S>{x.x, y.x, z.x});
  const Vec3<S> to_y = from_joint(link, at.R, Vec3<S>{x.y, y.y, z.y});
  const Vec3<S> to_z = from_joint(link, at.R, Vec3<S>{x.z, y.z, z.z});
  const Vec3<S> h = from_joint(link, at.R, I.h);
  parent.m += I.m;
  parent.h = parent.h + h;
  parent.xx += to_x.x;
  parent.xy += to_x.y;
  parent.yy += to_y.y;
  parent.xz += to_x.z;
  parent.yz += to_y.z;
  parent.zz += to_z.z;
  if (!link.A_moves) return;
  const auto p = constant<S>(link.A.p);
  const Vec3<S> mp = I.m * constant<S>(link.A.p);
  const Vec3<S> s = h + mp;  // X of the parent: + h p' + p h' + m p p'
  parent.h = parent.h + mp;
  parent.xx += p.x * (h.x + s.x);
  parent.xy += p.y * s.x + p.x * h.y;
  parent.yy += p.y * (h.y + s.y);
  parent.xz += p.z * s.x + p.x * h.z;
  parent.yz += p.z * s.y + p.y * h.z;
  parent.zz += p.z * (h.z + s.z);
}

/// Derivatives of a link's motion and forces along one direction of the state space, or several.
template <typename L>
struct Tangent {
  Vec3<L> omega, alpha, accel;
  Spin<L> E;
  Vec3<L> force, moment;
};

/// Variables along which tangents are taken: q, dq or both (bitwise or).
enum : unsigned { kOfPosition = 1, kOfVelocity = 2 };

/// Rates of a joint variable and its derivative along the directions.
template <typename L>
struct Seed {
  L s, ds;
};

/// Computes one link's tangents from its parent's; requires forward_step().
///
/// @param above  tangents of the parent; null where they are zero.
template <unsigned kOf, typename S, typename L>
inline void tangent_step(const Link& link, const LinkInertia& I, const LinkState<S>& at,
                         const Seed<L>& seed, const Tangent<L>* above, Tangent<L>& t) {
  namespace d = recursion_detail;
  const bool revolute = link.type == JointType::kRevolute;
  t.omega = t.alpha = t.accel = d::zero3<L>();
  if (above != nullptr) {
    t.omega = to_joint(link, at.R, above->omega);
    t.alpha = to_joint(link, at.R, above->alpha);
    Vec3<L> accel = above->accel;
    if (link.A_moves) accel = accel + apply(above->E, constant<S>(link.A.p));
    t.accel = to_joint(link, at.R, accel);
  }
  if (revolute) {
    if constexpr ((kOf & kOfPosition) != 0) {  // d(R' x)/ds = (R' x) x z
      t.omega.x += seed.s * at.omega.y;
      t.omega.y -= seed.s * at.omega.x;
      // alpha before the joint's own is added
      t.alpha.x += seed.s * (at.alpha.y + at.ds * at.omega.x);
      t.alpha.y -= seed.s * (at.alpha.x - at.ds * at.omega.y);
      t.accel.x += seed.s * at.accel.y;
      t.accel.y -= seed.s * at.accel.x;
    }
    t.alpha.x += at.ds * t.omega.y;
    t.alpha.y -= at.ds * t.omega.x;
    if constexpr ((kOf & kOfVelocity) != 0) {
      t.alpha.x += seed.ds * at.omega.y;
      t.alpha.y -= seed.ds * at.omega.x;
      t.omega.z += seed.ds;
    }
  }
  const L xx = (at.omega.x + at.omega.x) * t.omega.x;
  const L yy = (at.omega.y + at.omega.y) * t.omega.y;
  const L zz = (at.omega.z + at.omega.z) * t.omega.z;
  const L yz = at.omega.y * t.omega.z + at.omega.z * t.omega.y;
  const L xz = at.omega.x * t.omega.z + at.omega.z * t.omega.x;
  const L xy = at.omega.x * t.omega.y + at.omega.y * t.omega.x;
  t.E = {{-(yy + zz), xy + t.alpha.z, xz - t.alpha.y},
         {xy - t.alpha.z, -(xx + zz), yz + t.alpha.x},
         {xz + t.alpha.y, yz - t.alpha.x, -(xx + yy)}};
  if (!revolute) {
    if constexpr ((kOf & kOfPosition) != 0) t.accel = t.accel + seed.s * at.E.z;
    const S twice = at.ds + at.ds;
    t.accel = t.accel + at.s * t.E.z;
    t.accel.x += twice * t.omega.y;
    t.accel.y -= twice * t.omega.x;
    if constexpr ((kOf & kOfVelocity) != 0) {
      const L pair = seed.ds + seed.ds;
      t.accel.x += pair * at.omega.y;
      t.accel.y -= pair * at.omega.x;
    }
  }
  link_wrench(link, I, t.accel, t.E, t.force, t.moment);
}

/// Adds one link's tangents of force and moment to its parent's; requires backward_pass().
template <unsigned kOf, typename S, typename L>
inline void tangent_back(const Link& link, const LinkState<S>& at, const Seed<L>& seed,
                         const Tangent<L>& t, Tangent<L>& above) {
  Vec3<L> force = t.force;
  Vec3<L> moment = t.moment;
  if (link.type == JointType::kPrismatic) {
    moment.x -= at.s * force.y;
    moment.y += at.s * force.x;
  }
  if constexpr ((kOf & kOfPosition) != 0) {  // d(R x)/ds = R (z x x)
    if (link.type == JointType::kRevolute) {
      force.x -= seed.s * at.force.y;
      force.y += seed.s * at.force.x;
      moment.x -= seed.s * at.moment.y;
      moment.y += seed.s * at.moment.x;
    } else {
      moment.x -= seed.s * at.force.y;
      moment.y += seed.s * at.force.x;
    }
  }
  recursion_detail::to_parent(link, at.R, force, moment, above.force, above.moment);
}

/// Motion of the masses that a link carries, relative to the frame of the link: the sums of m xdot
/// and of m x xdot'.
template <typename S>
struct CarriedMomentum {
  Vec3<S> p;
  Mat3<S> W;
};

/// Adds the momentum c of a link to that of its parent; I is the inertia that the link carries.
template <typename S>
inline void carry_momentum(const Link& link, const LinkState<S>& at, const InertiaOf<S>& I,
                           CarriedMomentum<S> c, CarriedMomentum<S>& parent) {
  Mat3<S>& W = c.W;
  if (link.type == JointType::kRevolute) {  // xdot += z ds x x
    c.p.x -= at.ds * I.h.y;
    c.p.y += at.ds * I.h.x;
    W.row0.x -= at.ds * I.xy;
    W.row0.y += at.ds * I.xx;
    W.row1.x -= at.ds * I.yy;
    W.row1.y += at.ds * I.xy;
    W.row2.x -= at.ds * I.yz;
    W.row2.y += at.ds * I.xz;
  } else {  // xdot += z ds, x += z s
    W.row0.z += at.ds * I.h.x;
    W.row1.z += at.ds * I.h.y;
    W.row2.z += at.ds * I.h.z;
    c.p.z += at.ds * I.m;
    W.row2 = W.row2 + at.s * c.p;
  }
  // R W R': R times the rows of W, then R times the columns of that product.
  const Vec3<S> x = from_joint(link, at.R, W.row0);
  const Vec3<S> y = from_joint(link, at.R, W.row1);
  const Vec3<S> z = from_joint(link, at.R, W.row2);
  Mat3<S> turned = transpose(Mat3<S>{from_joint(link, at.R, Vec3<S>{x.x, y.x, z.x}),
                                     from_joint(link, at.R, Vec3<S>{x.y, y.y, z.y}),
                                     from_joint(link, at.R, Vec3<S>{x.z, y.z, z.z})});
  const Vec3<S> p = from_joint(link, at.R, c.p);
  if (link.A_moves) {
    const auto r = constant<S>(link.A.p);
    turned.row0 = turned.row0 + r.x * p;
    turned.row1 = turned.row1 + r.y * p;
    turned.row2 = turned.row2 + r.z * p;
  }
  parent.p = parent.p + p;
  parent.W.row0 = parent.W.row0 + turned.row0;
  parent.W.row1 = parent.W.row1 + turned.row1;
  parent.W.row2 = parent.W.row2 + turned.row2;
}

/// Derivatives of the forces on all links that a joint carries, by the joint's variable, velocity
/// and acceleration, at a link's origin and in its axes.
///
/// A small motion of a joint adds a + gamma x x + 2 w x xdot to the acceleration at x of all that it
/// carries, where xdot is relative to the joint's origin: this is one motion of one composite body.
/// By the same symmetry, `spin` . w is the part of the joint's torque that belongs to w where a
/// joint above it moves so. Source: Singh, Russell and Wensing, IEEE RA-L 7(2), 2022.
template <typename S>
struct JointForces {
  Vec3<S> force, moment;  ///< by the acceleration
  Vec3<S> spin;
  Vec3<S> position_force, position_moment;
  Vec3<S> velocity_force, velocity_moment;
};

/// Computes them for one joint at its own link; requires backward_pass().
///
/// @param I, c  inertia and momentum that the link carries.
template <typename S>
inline void joint_forces(const Link& link, const LinkState<S>& at, const InertiaOf<S>& I,
                         const CarriedMomentum<S>& c, JointForces<S>& to) {
  const Vec3<S>& h = I.h;
  const Vec3<S>& e = at.E.z;
  const Vec3<S> p = c.p + cross(at.omega, h);  // with the link's own rotation
  const S gx = at.omega.y + at.omega.y;        // 2 omega x z
  const S gy = -(at.omega.x + at.omega.x);
  if (link.type == JointType::kPrismatic) {
    to.force = {S(0.0), S(0.0), I.m};
    to.moment = {h.y, -h.x, S(0.0)};
    to.spin = {p.y + p.y, -(p.x + p.x), S(0.0)};
    to.velocity_force = {I.m * gx, I.m * gy, S(0.0)};
    to.velocity_moment = {-(h.z * gy), h.z * gx, h.x * gy - h.y * gx};
    to.position_force = I.m * e;
    to.position_moment = cross(h, e);
    to.position_moment.x -= at.force.y;
    to.position_moment.y += at.force.x;
    return;
  }
  const Vec3<S> x = c.W.row0 + cross(at.omega, Vec3<S>{I.xx, I.xy, I.xz});
  const Vec3<S> y = c.W.row1 + cross(at.omega, Vec3<S>{I.xy, I.yy, I.yz});
  const Vec3<S> z = c.W.row2 + cross(at.omega, Vec3<S>{I.xz, I.yz, I.zz});
  const S twice = x.x + y.y + (x.x + y.y);
  const S about_x = I.yy + I.zz;
  const S about_y = I.xx + I.zz;
  to.force = {-h.y, h.x, S(0.0)};
  to.moment = {-I.xz, -I.yz, I.xx + I.yy};
  to.spin = {-(x.z + x.z), -(y.z + y.z), twice};
  to.velocity_force = {gy * h.z - (p.y + p.y), (p.x + p.x) - gx * h.z, gx * h.y - gy * h.x};
  to.velocity_moment = {about_x * gx - I.xy * gy - (z.x + z.x),
                        about_y * gy - I.xy * gx - (z.y + z.y), twice - I.xz * gx - I.yz * gy};
  const Vec3<S> swept = cross(e, h);
  to.position_force = {swept.x + I.m * at.accel.y + gy * p.z - at.force.y,
                       swept.y - I.m * at.accel.x - gx * p.z + at.force.x,
                       swept.z + gx * p.y - gy * p.x};
  to.position_moment = {h.z * at.accel.x + about_x * e.x - I.xy * e.y - I.xz * e.z +
                            gx * (y.y + z.z) - gy * y.x - at.moment.y,
                        h.z * at.accel.y + about_y * e.y - I.xy * e.x - I.yz * e.z +
                            gy * (x.x + z.z) - gx * x.y + at.moment.x,
                        (I.xx + I.yy) * e.z - I.xz * e.x - I.yz * e.y - h.x * at.accel.x -
                            h.y * at.accel.y - gx * x.z - gy * y.z};
}

/// Moves them to the parent's origin, with the parent's axes.
template <typename S>
inline void to_parent(const Link& link, const LinkState<S>& at, const Vec3<S>& parent_omega,
                      JointForces<S>& t) {
  const bool slides = link.type == JointType::kPrismatic;
  const auto p = constant<S>(link.A.p);
  const auto move = [&](Vec3<S>& force, Vec3<S>& moment) {
    if (slides) {  // (s z) x force
      moment.x -= at.s * force.y;
      moment.y += at.s * force.x;
    }
    force = from_joint(link, at.R, force);
    moment = from_joint(link, at.R, moment);
    if (link.A_moves) moment = moment + cross(p, force);
  };
  if (slides) {  // twice the velocity of the link's origin against the joint's, times force
    const Vec3<S> u{at.s * at.omega.y, -(at.s * at.omega.x), at.ds};
    t.spin = t.spin + cross(u + u, t.force);
  }
  move(t.force, t.moment);
  move(t.position_force, t.position_moment);
  move(t.velocity_force, t.velocity_moment);
  t.spin = from_joint(link, at.R, t.spin);
  if (!link.A_moves) return;
  const Vec3<S> u = cross(parent_omega, p);
  t.spin = t.spin + cross(u + u, t.force);
}

}  // namespace veridyn
