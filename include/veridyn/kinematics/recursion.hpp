#pragma once

#include <vector>

#include "veridyn/kinematics/links.hpp"
#include "veridyn/math/sine_cosine.hpp"

// Motion along the tree, over any scalar S: double, a pack of samples, a dual number. One source
// for all of them. All vectors of a link are written in the link's own frame, at its origin.
//
// Source of the forms: Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 5.

namespace veridyn {

template <typename S>
struct LinkState {
  S s, sine, cosine, ds, dds;
  Vec3<S> omega;  ///< angular velocity
  Vec3<S> alpha;  ///< its derivative
  Vec3<S> accel;  ///< acceleration of the origin, minus gravity
  Vec3<S> force, moment;
};

/// Angular and linear velocity of a link per unit of one coordinate's velocity.
template <typename S>
struct Column {
  Vec3<S> w, v;
};

/// What the passes write, as plain arrays: see links.hpp for why.
template <typename S>
struct Workspace {
  LinkState<S>* link;        ///< one per link
  Column<S>* jacobian;       ///< one per mover
  Column<S>* jacobian_rate;  ///< one per mover, time derivative within the link's frame
};

/// A workspace with its memory; sized once, reused for ever.
template <typename S>
class Recursion : public Workspace<S> {
 public:
  explicit Recursion(const Links& tree)
      : links_(static_cast<size_t>(tree.count)), columns_(2 * static_cast<size_t>(tree.movers)) {
    point();
  }
  Recursion(const Recursion& other) : links_(other.links_), columns_(other.columns_) { point(); }
  Recursion& operator=(const Recursion& other) {
    links_ = other.links_;
    columns_ = other.columns_;
    point();
    return *this;
  }

 private:
  void point() {
    this->link = links_.data();
    this->jacobian = columns_.data();
    this->jacobian_rate = columns_.data() + columns_.size() / 2;
  }

  std::vector<LinkState<S>> links_;
  std::vector<Column<S>> columns_;
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
template <typename S>
inline void carry(const Posed& T, Vec3<S>& w, Vec3<S>& v) {
  v = rotate_back(T.R, v + cross(w, T.p));
  w = rotate_back(T.R, w);
}

}  // namespace recursion_detail

/// One link's joint variable, its derivatives, and the sine and cosine.
template <typename S>
inline void joint_step(const Links& tree, int k, const S* q, const S* dq, const S* ddq,
                       const Workspace<S>& r) {
  const Link& link = tree.link[k];
  S s(link.offset);
  S ds(0.0);
  S dds(0.0);
  for (int e = link.first_share; e < link.end_share; ++e) {
    const S c(tree.share[e].coefficient);
    const int i = tree.share[e].coordinate;
    s += c * q[i];
    ds += c * dq[i];
    dds += c * ddq[i];
  }
  LinkState<S>& at = r.link[k];
  at.s = s;
  at.ds = ds;
  at.dds = dds;
  if (link.motion == Motion::kTurns) sine_cosine(s, at.sine, at.cosine);
}

/// One link's velocity and acceleration from its parent's.
template <typename S>
inline void forward_step(const Links& tree, int k, const Vec3d& gravity, const Workspace<S>& r) {
  namespace d = recursion_detail;
  const Link& link = tree.link[k];
  LinkState<S>& at = r.link[k];
  Vec3<S> omega = d::zero3<S>();
  Vec3<S> alpha = d::zero3<S>();
  Vec3<S> accel{S(-gravity.x), S(-gravity.y), S(-gravity.z)};
  if (link.parent >= 0) {
    const LinkState<S>& above = r.link[link.parent];
    omega = above.omega;
    alpha = above.alpha;
    accel = above.accel;
  }
  if (!link.A_is_identity) d::carry(link.A, omega, alpha, accel);
  if (link.motion == Motion::kTurns) {
    omega = d::turn_back(at.sine, at.cosine, omega);
    alpha = d::turn_back(at.sine, at.cosine, alpha);
    accel = d::turn_back(at.sine, at.cosine, accel);
    alpha.x += omega.y * at.ds;  // omega_parent x z ds
    alpha.y -= omega.x * at.ds;
    alpha.z += at.dds;
    omega.z += at.ds;
  } else if (link.motion == Motion::kSlides) {
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

/// Joint variables, velocities and accelerations of all links.
///
/// @param q, dq, ddq  n entries each.
/// @param gravity     in the world [m/s^2]; zero for pure motion.
template <typename S>
void forward_pass(const Links& tree, const S* q, const S* dq, const S* ddq, const Vec3d& gravity,
                  const Workspace<S>& r) {
  for (int k = 0; k < tree.count; ++k) joint_step(tree, k, q, dq, ddq, r);
  for (int k = 0; k < tree.count; ++k) forward_step(tree, k, gravity, r);
}

/// Body Jacobian of one link from its parent's.
template <typename S>
inline void jacobian_step(const Links& tree, int k, const Workspace<S>& r) {
  namespace d = recursion_detail;
  const Link& link = tree.link[k];
  const LinkState<S>& at = r.link[k];
  for (int m = link.first_mover; m < link.end_mover; ++m) {
    const Mover& mover = tree.mover[m];
    Vec3<S> w = d::zero3<S>();
    Vec3<S> v = d::zero3<S>();
    if (mover.above >= 0) {
      w = r.jacobian[mover.above].w;
      v = r.jacobian[mover.above].v;
      if (!link.A_is_identity) d::carry(link.A, w, v);
      if (link.motion == Motion::kTurns) {
        w = d::turn_back(at.sine, at.cosine, w);
        v = d::turn_back(at.sine, at.cosine, v);
      } else if (link.motion == Motion::kSlides) {
        v.x += w.y * at.s;
        v.y -= w.x * at.s;
      }
    }
    if (mover.share != 0.0 && link.motion == Motion::kTurns) w.z += S(mover.share);
    if (mover.share != 0.0 && link.motion == Motion::kSlides) v.z += S(mover.share);
    if (!link.B_is_identity) d::carry(link.B, w, v);
    r.jacobian[m].w = w;
    r.jacobian[m].v = v;
  }
}

/// Body Jacobians of all links; needs forward_pass() of the same q.
template <typename S>
void jacobian_pass(const Links& tree, const Workspace<S>& r) {
  for (int k = 0; k < tree.count; ++k) jacobian_step(tree, k, r);
}

/// Time derivatives of the body Jacobians, taken within each link's frame; needs forward_pass() and
/// jacobian_pass().
template <typename S>
void jacobian_rate_pass(const Links& tree, const Workspace<S>& r) {
  namespace d = recursion_detail;
  for (int k = 0; k < tree.count; ++k) {
    const Link& link = tree.link[k];
    const LinkState<S>& at = r.link[k];
    for (int m = link.first_mover; m < link.end_mover; ++m) {
      const int above = tree.mover[m].above;
      Vec3<S> dw = d::zero3<S>();
      Vec3<S> dv = d::zero3<S>();
      if (above >= 0) {
        Vec3<S> w = r.jacobian[above].w;
        Vec3<S> v = r.jacobian[above].v;
        dw = r.jacobian_rate[above].w;
        dv = r.jacobian_rate[above].v;
        if (!link.A_is_identity) {
          d::carry(link.A, w, v);
          d::carry(link.A, dw, dv);
        }
        if (link.motion == Motion::kTurns) {
          w = d::turn_back(at.sine, at.cosine, w);
          v = d::turn_back(at.sine, at.cosine, v);
          dw = d::turn_back(at.sine, at.cosine, dw);
          dv = d::turn_back(at.sine, at.cosine, dv);
          dw.x += w.y * at.ds;  // w x z ds
          dw.y -= w.x * at.ds;
          dv.x += v.y * at.ds;
          dv.y -= v.x * at.ds;
        } else if (link.motion == Motion::kSlides) {
          dv.x += dw.y * at.s + w.y * at.ds;
          dv.y -= dw.x * at.s + w.x * at.ds;
        }
        if (!link.B_is_identity) d::carry(link.B, dw, dv);
      }
      r.jacobian_rate[m].w = dw;
      r.jacobian_rate[m].v = dv;
    }
  }
}

}  // namespace veridyn
