#pragma once

#include "veridyn/kinematics/recursion.hpp"

// Forces along the tree, over any scalar S: one source for single states, packs of samples and dual
// numbers.
//
// Source of the forms: Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 5; regressor:
// Atkeson, An and Hollerbach, IJRR 5(3), 1986; here written with body Jacobians, so that couplings
// cost nothing extra.

namespace veridyn {

namespace recursion_detail {

/// Force and moment back across a rigid piece.
template <typename S>
inline void carry_back(const Posed& T, Vec3<S>& force, Vec3<S>& moment) {
  force = rotate(T.R, force);
  moment = rotate(T.R, moment);
  const Vec3<S> arm_moment = cross(T.p, force);
  moment = moment + arm_moment;
}

}  // namespace recursion_detail

/// What the regressor needs of one body's motion, for all coordinates that move it:
///
///   f = m a + E h,   n = N L + h x a,   E = [alpha]x + [omega]x [omega]x,   N L = alpha-part +
///   omega x L omega
///
/// The entries of N are those of E up to sign, and differences of squares.
template <typename S>
struct BodyMotion {
  Vec3<S> accel, alpha;
  Vec3<S> E_x, E_y, E_z;  ///< columns of E
  Vec3<S> products;       ///< omega_y omega_z, omega_x omega_z, omega_x omega_y
  Vec3<S> differences;    ///< omega_y^2 - omega_z^2, omega_z^2 - omega_x^2, omega_x^2 - omega_y^2
};

template <typename S>
inline BodyMotion<S> body_motion(const LinkState<S>& at) {
  const S xx = at.omega.x * at.omega.x;
  const S yy = at.omega.y * at.omega.y;
  const S zz = at.omega.z * at.omega.z;
  const S yz = at.omega.y * at.omega.z;
  const S xz = at.omega.x * at.omega.z;
  const S xy = at.omega.x * at.omega.y;
  const Vec3<S>& alpha = at.alpha;
  // clang-format off
  return {at.accel, alpha,
          {-(yy + zz), xy + alpha.z, xz - alpha.y},
          {xy - alpha.z, -(xx + zz), yz + alpha.x},
          {xz + alpha.y, yz - alpha.x, -(xx + yy)},
          {yz, xz, xy},
          {yy - zz, zz - xx, xx - yy}};
  // clang-format on
}

/// The ten entries of the regressor that belong to one body and one coordinate, tau_i = w_i . n +
/// v_i . f; needs forward_pass() and jacobian_pass(). Order: InertialParameters.
///
/// @param put  called as put(k, entry) for k = 0 .. 9, so that entries go from registers to where
/// they belong.
template <typename S, typename Put>
inline void regressor_entries(const BodyMotion<S>& b, const Column<S>& c, const Put& put) {
  const Vec3<S>& w = c.w;
  const Vec3<S> turned = cross(b.accel, w);  // w . (h x a) = h . (a x w)
  put(0, dot(c.v, b.accel));
  put(1, dot(c.v, b.E_x) + turned.x);
  put(2, dot(c.v, b.E_y) + turned.y);
  put(3, dot(c.v, b.E_z) + turned.z);
  put(4, w.x * b.alpha.x + w.y * b.products.y - w.z * b.products.z);
  put(5, w.y * b.E_y.z - w.x * b.E_x.z + w.z * b.differences.z);
  put(6, w.y * b.alpha.y + w.z * b.products.z - w.x * b.products.x);
  put(7, w.x * b.E_x.y - w.z * b.E_z.y + w.y * b.differences.y);
  put(8, w.z * b.E_z.x - w.y * b.E_y.x + w.x * b.differences.x);
  put(9, w.z * b.alpha.z + w.x * b.products.x - w.y * b.products.y);
}

/// L a for the six entries of a symmetric tensor in the order of InertialParameters.
template <typename P, typename S>
inline Vec3<S> inertia_times(const P* L, const Vec3<S>& a) {
  return {L[0] * a.x + L[1] * a.y + L[3] * a.z, L[1] * a.x + L[2] * a.y + L[4] * a.z,
          L[3] * a.x + L[4] * a.y + L[5] * a.z};
}

/// Force and moment that one body needs for its motion; none where the link has no body.
template <typename P, typename S>
inline void body_force(const Links& tree, int k, const P* phi, const Workspace<S>& r) {
  LinkState<S>& at = r.link[k];
  at.force = recursion_detail::zero3<S>();
  at.moment = recursion_detail::zero3<S>();
  if (tree.link[k].body < 0) return;
  const P* p = phi + 10 * tree.link[k].body;
  const Vec3<P> h{p[1], p[2], p[3]};
  const Vec3<S> swept = cross(at.omega, h);
  const Vec3<S> spin = inertia_times(p + 4, at.omega);
  const Vec3<S> weight{p[0] * at.accel.x, p[0] * at.accel.y, p[0] * at.accel.z};
  at.force = weight + cross(at.alpha, h) + cross(at.omega, swept);
  at.moment = inertia_times(p + 4, at.alpha) + cross(at.omega, spin) + cross(h, at.accel);
}

/// One link's share in the joint torques; its force and moment go on to its parent.
template <typename S>
inline void backward_step(const Links& tree, int k, const Workspace<S>& r, S* tau) {
  namespace d = recursion_detail;
  const Link& link = tree.link[k];
  const LinkState<S>& at = r.link[k];
  Vec3<S> force = at.force;
  Vec3<S> moment = at.moment;
  if (!link.B_is_identity) d::carry_back(link.B, force, moment);
  const S along = link.motion == Motion::kTurns ? moment.z : force.z;
  for (int e = link.first_share; e < link.end_share; ++e) {
    tau[tree.share[e].coordinate] += S(tree.share[e].coefficient) * along;
  }
  if (link.parent < 0) return;
  if (link.motion == Motion::kTurns) {
    force = d::turn(at.sine, at.cosine, force);
    moment = d::turn(at.sine, at.cosine, moment);
  } else if (link.motion == Motion::kSlides) {
    moment.x -= at.s * force.y;  // (s z) x force
    moment.y += at.s * force.x;
  }
  if (!link.A_is_identity) d::carry_back(link.A, force, moment);
  LinkState<S>& above = r.link[link.parent];
  above.force = above.force + force;
  above.moment = above.moment + moment;
}

/// Joint torques of rigid bodies with parameters phi (10 per body); needs forward_pass().
///
/// @param tau  n entries, overwritten.
template <typename P, typename S>
void backward_pass(const Links& tree, const P* phi, const Workspace<S>& r, S* tau) {
  for (int i = 0; i < tree.joints; ++i) tau[i] = S(0.0);
  for (int k = 0; k < tree.count; ++k) body_force(tree, k, phi, r);
  for (int k = tree.count - 1; k >= 0; --k) backward_step(tree, k, r, tau);
}

}  // namespace veridyn
