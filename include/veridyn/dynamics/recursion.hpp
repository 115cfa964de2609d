#pragma once

#include "veridyn/kinematics/recursion.hpp"

// Forces along the tree, over any scalar S: one source for single states, packs of samples and dual numbers.
//
// Source of the forms: Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 5; regressor: Atkeson, An and
// Hollerbach, IJRR 5(3), 1986; here written with body Jacobians, so that couplings cost nothing extra.

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

/// The ten entries of the regressor that belong to one body and one coordinate; needs forward_pass() and
/// jacobian_pass(). Order: InertialParameters.
///
///   tau_i = w_i . n + v_i . f,   f = m a + alpha x h + omega x (omega x h),   n = L alpha + omega x L omega + h x a
template <typename S>
inline void regressor_entries(const typename Recursion<S>::LinkState& at,
                              const typename Recursion<S>::Column& c, S* y) {
  const Vec3<S> u = cross(c.w, at.omega);   // (w x omega): pairs with L omega
  const Vec3<S> p = cross(c.v, at.omega);   // so that v . omega x (omega x h) = (v x omega) x omega . h
  y[0] = dot(c.v, at.accel);
  const Vec3<S> h = cross(c.v, at.alpha) + cross(p, at.omega) + cross(at.accel, c.w);
  y[1] = h.x;
  y[2] = h.y;
  y[3] = h.z;
  y[4] = c.w.x * at.alpha.x + u.x * at.omega.x;
  y[5] = c.w.x * at.alpha.y + c.w.y * at.alpha.x + u.x * at.omega.y + u.y * at.omega.x;
  y[6] = c.w.y * at.alpha.y + u.y * at.omega.y;
  y[7] = c.w.x * at.alpha.z + c.w.z * at.alpha.x + u.x * at.omega.z + u.z * at.omega.x;
  y[8] = c.w.y * at.alpha.z + c.w.z * at.alpha.y + u.y * at.omega.z + u.z * at.omega.y;
  y[9] = c.w.z * at.alpha.z + u.z * at.omega.z;
}

/// L a for the six entries of a symmetric tensor in the order of InertialParameters.
template <typename P, typename S>
inline Vec3<S> inertia_times(const P* L, const Vec3<S>& a) {
  return {L[0] * a.x + L[1] * a.y + L[3] * a.z, L[1] * a.x + L[2] * a.y + L[4] * a.z,
          L[3] * a.x + L[4] * a.y + L[5] * a.z};
}

/// Joint torques of rigid bodies with parameters phi (10 per body); needs forward_pass().
///
/// @param tau  n entries, overwritten.
template <typename P, typename S>
void backward_pass(const Tree& tree, const P* phi, Recursion<S>& r, S* tau) {
  namespace d = recursion_detail;
  for (int i = 0; i < tree.joints; ++i) tau[i] = S(0.0);
  for (size_t k = 0; k < tree.links.size(); ++k) {
    auto& at = r.links[k];
    at.force = d::zero3<S>();
    at.moment = d::zero3<S>();
    if (tree.links[k].body < 0) continue;
    const P* p = phi + 10 * tree.links[k].body;
    const Vec3<P> h{p[1], p[2], p[3]};
    const Vec3<S> swept = cross(at.omega, h);
    const Vec3<S> spin = inertia_times(p + 4, at.omega);
    const Vec3<S> weight{p[0] * at.accel.x, p[0] * at.accel.y, p[0] * at.accel.z};
    at.force = weight + cross(at.alpha, h) + cross(at.omega, swept);
    at.moment = inertia_times(p + 4, at.alpha) + cross(at.omega, spin) + cross(h, at.accel);
  }
  for (size_t l = tree.links.size(); l-- > 0;) {
    const Tree::Link& link = tree.links[l];
    const auto& at = r.links[l];
    Vec3<S> force = at.force;
    Vec3<S> moment = at.moment;
    if (!link.B_is_identity) d::carry_back(link.B, force, moment);
    const S& along = link.type == JointType::kRevolute ? moment.z : force.z;
    for (const Tree::Share& share : link.shares) tau[share.coordinate] += S(share.coefficient) * along;
    if (link.parent < 0) continue;
    if (link.type == JointType::kRevolute) {
      force = d::turn(at.sine, at.cosine, force);
      moment = d::turn(at.sine, at.cosine, moment);
    } else if (link.type == JointType::kPrismatic) {
      moment.x -= at.s * force.y;  // (s z) x force
      moment.y += at.s * force.x;
    }
    if (!link.A_is_identity) d::carry_back(link.A, force, moment);
    auto& above = r.links[link.parent];
    above.force = above.force + force;
    above.moment = above.moment + moment;
  }
}

}  // namespace veridyn
