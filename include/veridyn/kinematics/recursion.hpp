#pragma once

#include <array>
#include <vector>

#include "veridyn/kinematics/tree.hpp"
#include "veridyn/math/sine_cosine.hpp"

// Motion along the tree, over any scalar S: double, a pack of samples, a dual number. One source
// for all of them. All vectors of a link are written in the link's own frame, at its origin.
//
// Source of the forms: Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 5.

namespace veridyn {

/// Everything one pass writes; sized once, reused for ever.
template <typename S>
struct Recursion {
  struct LinkState {
    S s, sine, cosine, ds, dds;
    Vec3<S> omega;  ///< angular velocity
    Vec3<S> alpha;  ///< its derivative
    Vec3<S> accel;  ///< acceleration of the origin, minus gravity
    Vec3<S> force, moment;
  };
  struct Column {
    Vec3<S> w, v;  ///< angular and linear velocity of the link per unit of one coordinate's velocity
  };

  explicit Recursion(const Tree& tree)
      : links(tree.links.size()), jacobian(tree.links.size() * tree.joints), jacobian_rate(jacobian.size()) {}

  std::vector<LinkState> links;
  std::vector<Column> jacobian;       ///< (links x n), row by row; only the support is filled
  std::vector<Column> jacobian_rate;  ///< the same, time derivative within the link's frame
};

namespace recursion_detail {

template <typename S>
inline Vec3<S> zero3() {
  return {S(0.0), S(0.0), S(0.0)};
}

/// Rz(s)' a.
template <typename S>
inline Vec3<S> turn_back(const S& sine, const S& cosine, const Vec3<S>& a) {
  return {cosine * a.x + sine * a.y, cosine * a.y - sine * a.x, a.z};
}

/// Rz(s) a.
template <typename S>
inline Vec3<S> turn(const S& sine, const S& cosine, const Vec3<S>& a) {
  return {cosine * a.x - sine * a.y, cosine * a.y + sine * a.x, a.z};
}

/// omega, alpha, accel from one end of a rigid piece to the other.
template <typename S>
inline void carry(const Posed& T, Vec3<S>& omega, Vec3<S>& alpha, Vec3<S>& accel) {
  const Vec3<S> swept = cross(omega, T.p);
  accel = accel + cross(alpha, T.p) + cross(omega, swept);
  omega = rotate_back(T.R, omega);
  alpha = rotate_back(T.R, alpha);
  accel = rotate_back(T.R, accel);
}

/// One column of a Jacobian across a rigid piece.
template <typename Column>
inline void carry(const Posed& T, Column& c) {
  c.v = rotate_back(T.R, c.v + cross(c.w, T.p));
  c.w = rotate_back(T.R, c.w);
}

}  // namespace recursion_detail

/// Joint variables, velocities and accelerations of all links.
///
/// @param q, dq, ddq  n entries each.
/// @param gravity     in the world [m/s^2]; zero for pure motion.
template <typename S>
void forward_pass(const Tree& tree, const S* q, const S* dq, const S* ddq, const Vec3d& gravity, Recursion<S>& r) {
  namespace d = recursion_detail;
  for (size_t k = 0; k < tree.links.size(); ++k) {
    const Tree::Link& link = tree.links[k];
    auto& at = r.links[k];
    at.s = S(link.offset);
    at.ds = S(0.0);
    at.dds = S(0.0);
    for (const Tree::Share& share : link.shares) {
      const S c(share.coefficient);
      at.s += c * q[share.coordinate];
      at.ds += c * dq[share.coordinate];
      at.dds += c * ddq[share.coordinate];
    }
    if (link.type == JointType::kRevolute) sine_cosine(at.s, at.sine, at.cosine);
  }
  for (size_t k = 0; k < tree.links.size(); ++k) {
    const Tree::Link& link = tree.links[k];
    auto& at = r.links[k];
    Vec3<S> omega = d::zero3<S>();
    Vec3<S> alpha = d::zero3<S>();
    Vec3<S> accel{S(-gravity.x), S(-gravity.y), S(-gravity.z)};
    if (link.parent >= 0) {
      const auto& above = r.links[link.parent];
      omega = above.omega;
      alpha = above.alpha;
      accel = above.accel;
    }
    if (!link.A_is_identity) d::carry(link.A, omega, alpha, accel);
    if (link.type == JointType::kRevolute) {
      omega = d::turn_back(at.sine, at.cosine, omega);
      alpha = d::turn_back(at.sine, at.cosine, alpha);
      accel = d::turn_back(at.sine, at.cosine, accel);
      alpha.x += omega.y * at.ds;  // omega_parent x z ds
      alpha.y -= omega.x * at.ds;
      alpha.z += at.dds;
      omega.z += at.ds;
    } else if (link.type == JointType::kPrismatic) {
      const Vec3<S> along{S(0.0), S(0.0), at.s};
      const Vec3<S> swept = cross(omega, along);
      const S twice = at.ds + at.ds;
      accel = accel + cross(alpha, along) + cross(omega, swept);
      accel.x += omega.y * twice;  // 2 omega x z ds
      accel.y -= omega.x * twice;
      accel.z += at.dds;
    }
    if (!link.B_is_identity) d::carry(link.B, omega, alpha, accel);
    at.omega = omega;
    at.alpha = alpha;
    at.accel = accel;
  }
}

/// Body Jacobians of all links; needs forward_pass() of the same q.
template <typename S>
void jacobian_pass(const Tree& tree, Recursion<S>& r) {
  namespace d = recursion_detail;
  const int n = tree.joints;
  for (size_t k = 0; k < tree.links.size(); ++k) {
    const Tree::Link& link = tree.links[k];
    const auto& at = r.links[k];
    for (const int i : link.support) {
      typename Recursion<S>::Column c{d::zero3<S>(), d::zero3<S>()};
      bool moved = false;
      if (link.parent >= 0) {
        for (const int j : tree.links[link.parent].support) moved = moved || j == i;
      }
      if (moved) {
        c = r.jacobian[link.parent * n + i];
        if (!link.A_is_identity) d::carry(link.A, c);
        if (link.type == JointType::kRevolute) {
          c.w = d::turn_back(at.sine, at.cosine, c.w);
          c.v = d::turn_back(at.sine, at.cosine, c.v);
        } else if (link.type == JointType::kPrismatic) {
          c.v.x += c.w.y * at.s;
          c.v.y -= c.w.x * at.s;
        }
      }
      for (const Tree::Share& share : link.shares) {
        if (share.coordinate != i) continue;
        (link.type == JointType::kRevolute ? c.w : c.v).z += S(share.coefficient);
      }
      if (!link.B_is_identity) d::carry(link.B, c);
      r.jacobian[k * n + i] = c;
    }
  }
}

/// Time derivatives of the body Jacobians, taken within each link's frame; needs forward_pass() and
/// jacobian_pass().
template <typename S>
void jacobian_rate_pass(const Tree& tree, Recursion<S>& r) {
  namespace d = recursion_detail;
  const int n = tree.joints;
  for (size_t k = 0; k < tree.links.size(); ++k) {
    const Tree::Link& link = tree.links[k];
    const auto& at = r.links[k];
    for (const int i : link.support) {
      typename Recursion<S>::Column rate{d::zero3<S>(), d::zero3<S>()};
      bool moved = false;
      if (link.parent >= 0) {
        for (const int j : tree.links[link.parent].support) moved = moved || j == i;
      }
      if (moved) {
        typename Recursion<S>::Column c = r.jacobian[link.parent * n + i];
        rate = r.jacobian_rate[link.parent * n + i];
        if (!link.A_is_identity) {
          d::carry(link.A, c);
          d::carry(link.A, rate);
        }
        if (link.type == JointType::kRevolute) {
          c.w = d::turn_back(at.sine, at.cosine, c.w);
          c.v = d::turn_back(at.sine, at.cosine, c.v);
          rate.w = d::turn_back(at.sine, at.cosine, rate.w);
          rate.v = d::turn_back(at.sine, at.cosine, rate.v);
          const Vec3<S> spin{S(0.0), S(0.0), at.ds};
          rate.w = rate.w + cross(c.w, spin);
          rate.v = rate.v + cross(c.v, spin);
        } else if (link.type == JointType::kPrismatic) {
          rate.v.x += rate.w.y * at.s + c.w.y * at.ds;
          rate.v.y -= rate.w.x * at.s + c.w.x * at.ds;
        }
        if (!link.B_is_identity) d::carry(link.B, rate);
      }
      r.jacobian_rate[k * n + i] = rate;
    }
  }
}

}  // namespace veridyn
