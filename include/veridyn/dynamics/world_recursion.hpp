#pragma once

#include <type_traits>

#include "veridyn/dynamics/link_inertia.hpp"
#include "veridyn/kinematics/recursion.hpp"

// Rigid-body quantities of all links in one frame: the axes of the world, moments and velocities about the origin
// of the first joint. Matrices of the dynamics are then products of six numbers of one link with six of another,
// without any change of frame between them, and the inertias of links are sums.
//
// Sources: Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 6 and 7; derivatives: Carpentier
// and Mansard, RSS 2018; Singh, Russell and Wensing, IEEE RA-L 7(2), 2022.

namespace veridyn {

// True if a pivot is above zero. Symbolic scalars cannot be compared; their pivots count as positive.
inline bool is_positive(double x) {
  return x > 0.0;
}
inline bool is_positive(float x) {
  return x > 0.0F;
}
template <typename S>
inline bool is_positive(const S&) {
  return true;
}

/// A motion (angular velocity, velocity of the point at the origin) or a wrench (moment, force).
template <typename S>
using Screw = Column<S>;

template <typename A, typename B>
inline auto dot(const Screw<A>& a, const Screw<B>& b) {
  return dot(a.w, b.w) + dot(a.v, b.v);
}

template <typename A, typename B>
inline auto operator*(const A& k, const Screw<B>& a) -> Screw<decltype(k * a.w.x)> {
  return {k * a.w, k * a.v};
}

template <typename S>
inline Screw<S> operator+(const Screw<S>& a, const Screw<S>& b) {
  return {a.w + b.w, a.v + b.v};
}

template <typename S>
inline Screw<S> operator-(const Screw<S>& a, const Screw<S>& b) {
  return {a.w - b.w, a.v - b.v};
}

/// Rate of change of a motion vector b that is fixed in a body moving with a.
template <typename S>
inline Screw<S> cross(const Screw<S>& a, const Screw<S>& b) {
  return {cross(a.w, b.w), cross(a.w, b.v) + cross(a.v, b.w)};
}

/// Rate of change of a wrench f that is fixed in a body moving with a.
template <typename S>
inline Screw<S> cross_wrench(const Screw<S>& a, const Screw<S>& f) {
  return {cross(a.w, f.w) + cross(a.v, f.v), cross(a.w, f.v)};
}

/// Wrench that accelerates a body from rest by a.
template <typename S>
inline Screw<S> wrench(const InertiaOf<S>& I, const Screw<S>& a) {
  const Vec3<S>& w = a.w;
  const Vec3<S> own{(I.yy + I.zz) * w.x - I.xy * w.y - I.xz * w.z,
                    (I.xx + I.zz) * w.y - I.xy * w.x - I.yz * w.z,
                    (I.xx + I.yy) * w.z - I.xz * w.x - I.yz * w.y};
  return {cross(I.h, a.v) + own, I.m * a.v + cross(w, I.h)};
}

/// Sums of m xdot and of m x xdot' over the masses of one body or of several.
template <typename S>
struct Momentum {
  Vec3<S> p;
  Mat3<S> W;
};

/// The momentum of masses with the inertia I that move with `velocity`.
template <typename S>
inline Momentum<S> momentum(const InertiaOf<S>& I, const Screw<S>& velocity) {
  const Vec3<S>& w = velocity.w;
  const Vec3<S>& v = velocity.v;
  return {I.m * v + cross(w, I.h),
          {I.h.x * v + cross(w, Vec3<S>{I.xx, I.xy, I.xz}),
           I.h.y * v + cross(w, Vec3<S>{I.xy, I.yy, I.yz}),
           I.h.z * v + cross(w, Vec3<S>{I.xz, I.yz, I.zz})}};
}

/// Wrench that gives the masses the accelerations w x xdot.
template <typename S>
inline Screw<S> wrench(const Momentum<S>& c, const Vec3<S>& w) {
  const S trace = c.W.row0.x + c.W.row1.y + c.W.row2.z;
  return {trace * w - rotate_back(c.W, w), cross(w, c.p)};
}

/// The vector g for which w . g = axis . wrench(c, w) holds for every w.
template <typename S>
inline Vec3<S> spin_of(const Momentum<S>& c, const Screw<S>& axis) {
  const S trace = c.W.row0.x + c.W.row1.y + c.W.row2.z;
  return cross(c.p, axis.v) + trace * axis.w - rotate(c.W, axis.w);
}

/// A symmetric matrix.
template <typename S>
struct Symmetric3 {
  S xx, xy, yy, xz, yz, zz;
};

/// The product A a.
template <typename S>
inline Vec3<S> rotate(const Symmetric3<S>& A, const Vec3<S>& a) {
  return {A.xx * a.x + A.xy * a.y + A.xz * a.z, A.xy * a.x + A.yy * a.y + A.yz * a.z,
          A.xz * a.x + A.yz * a.y + A.zz * a.z};
}

/// Adds A - a b', which is symmetric, to `to`.
template <typename S>
inline void add_reduced(const Symmetric3<S>& A, const Vec3<S>& a, const Vec3<S>& b,
                        Symmetric3<S>& to) {
  to.xx += A.xx - a.x * b.x;
  to.xy += A.xy - a.x * b.y;
  to.yy += A.yy - a.y * b.y;
  to.xz += A.xz - a.x * b.z;
  to.yz += A.yz - a.y * b.z;
  to.zz += A.zz - a.z * b.z;
}

/// Resistance of a link to a motion if the joints that it carries move freely: moment = J w + H v, force = H'
/// w + M v.
template <typename S>
struct ArticulatedInertia {
  Symmetric3<S> J;
  Mat3<S> H;
  Symmetric3<S> M;
  Mat3<S> spin_moment, spin_force;  ///< map w to the moment and force of the accelerations w x xdot
};

/// Quantities of a joint that the passes along articulated bodies read.
template <typename S>
struct ArticulatedJoint {
  Screw<S> axis;     ///< the axis kAxis
  Screw<S> reduced;  ///< articulated inertia times axis, over their product with the axis
  Vec3<S> spin;      ///< effort per unit of a rotation w by the accelerations w x xdot
  S inverse;         ///< 1 / that product
};

/// Arrays of one number per link each; the lanes of L are neighbouring links. Links are numbered
/// from 0 to count - 1, parents before children.
template <typename S, typename L>
struct WorldRecursion {
  static constexpr bool kWide = !std::is_same<S, L>::value;
  static constexpr int lanes() {
    if constexpr (kWide) return L::kSize;
    return 1;
  }
  static constexpr int groups(int count) { return (count + lanes() - 1) / lanes(); }

  /// First array of each quantity; a screw has six, a vector three. Those that sum_over_subtrees() sums up over
  /// all that a link carries come first.
  enum Quantity : int {
    kInertia = 0,     ///< m, h, second moments
    kMomentum = 10,   ///< p, W
    kWrench = 22,     ///< wrench that moves the link
    kAxis = 28,       ///< motion per unit of the joint
    kForce = 34,      ///< wrench(inertia, axis)
    kSpin = 40,       ///< spin_of(momentum, axis)
    kVelocity = 43,
    kAcceleration = 49,  ///< minus gravity
    kDrift = 55,         ///< rate of the axis, d
    kTurn = 61,          ///< half of the change of acceleration by the joint's position
    kByPosition = 67,    ///< half of the change of what kWrench sums up, by the joint's position
    kByVelocity = 73,    ///< half of that change by the joint's velocity
    kTorqueByPosition = 79,  ///< see articulated_changes()
    kTorqueByVelocity = 80,
    kArrays = 81
  };

  S* data;
  int stride;  ///< entries of an array: a whole number of groups
  Pose<S>* pose;
  ArticulatedInertia<S>* articulated;
  ArticulatedJoint<S>* joint;

  S* array(int quantity) const { return data + quantity * stride; }  ///< first entry of a quantity, by link
  Vec3<S> vector(int quantity, int k) const {
    const S* x = array(quantity) + k;
    return {x[0], x[stride], x[2 * stride]};
  }
  Screw<S> screw(int quantity, int k) const {
    return {vector(quantity, k), vector(quantity + 3, k)};
  }
  void set(int quantity, int k, const Vec3<S>& a) const {
    S* x = array(quantity) + k;
    x[0] = a.x;
    x[stride] = a.y;
    x[2 * stride] = a.z;
  }
  void set(int quantity, int k, const Screw<S>& a) const {
    set(quantity, k, a.w);
    set(quantity + 3, k, a.v);
  }

  /// The accessors here read and write one link (k) or a group of links side by side (g).
  static L load(const S* from) {
    if constexpr (kWide) {
      L to;
      load_lanes(&from->v, to);
      return to;
    } else {
      return *from;
    }
  }
  /// Stores the first `count` lanes.
  static void store(const L& from, int count, S* to) {
    if constexpr (kWide) store_lanes(from, count, &to->v);
    if constexpr (!kWide) *to = from;
  }
  Vec3<L> lane_vector(int quantity, int g) const {
    const S* x = array(quantity) + g * lanes();
    return {load(x), load(x + stride), load(x + 2 * stride)};
  }
  Screw<L> lane_screw(int quantity, int g) const {
    return {lane_vector(quantity, g), lane_vector(quantity + 3, g)};
  }
  void set_lanes(int quantity, int g, const Vec3<L>& a) const {
    S* x = array(quantity) + g * lanes();
    store(a.x, lanes(), x);
    store(a.y, lanes(), x + stride);
    store(a.z, lanes(), x + 2 * stride);
  }
  void set_lanes(int quantity, int g, const Screw<L>& a) const {
    set_lanes(quantity, g, a.w);
    set_lanes(quantity + 3, g, a.v);
  }
  InertiaOf<L> lane_inertia(int g) const {
    const S* x = array(kInertia) + g * lanes();
    const auto at = [&](int k) { return load(x + k * stride); };
    return {at(0), {at(1), at(2), at(3)}, at(4), at(5), at(6), at(7), at(8), at(9)};
  }
  Momentum<L> lane_momentum(int g) const {
    return {lane_vector(kMomentum, g),
            {lane_vector(kMomentum + 3, g), lane_vector(kMomentum + 6, g),
             lane_vector(kMomentum + 9, g)}};
  }

  /// The value of x for a link's joint variable. Where every joint has a coordinate of its own, that coordinate
  /// replaces the joint variable, and its coefficient is part of the axis.
  static S joint_value(const Links& tree, int k, const S* x) {
    if (x == nullptr) return S(0.0);
    const Link& link = tree.link[k];
    if (tree.independent) return x[tree.coefficient[link.first_coefficient].coordinate];
    return along_joint(tree, link, x);
  }

  /// Computes poses and axes from the rotations of the links' states.
  void place(const Links& tree, const LinkState<S>* state) const {
    using C = typename ConstantOf<S>::type;
    const Vec3d origin = tree.count > 0 ? tree.link[0].A.p : Vec3d{0, 0, 0};
    for (int k = 0; k < tree.count; ++k) {
      const Link& link = tree.link[k];
      const LinkState<S>& at = state[k];
      Pose<S>& T = pose[k];
      if (link.parent < 0) {
        const auto p = constant<S>(link.A.p - origin);
        T = {at.R, {S(p.x), S(p.y), S(p.z)}};
      } else {
        const Pose<S>& above = pose[link.parent];
        T.p = above.p;
        if (link.A_moves) T.p = T.p + rotate(above.R, constant<S>(link.A.p));
        T.R = {to_joint(link, at.R, above.R.row0), to_joint(link, at.R, above.R.row1),
               to_joint(link, at.R, above.R.row2)};
      }
      Vec3<S> z{T.R.row0.z, T.R.row1.z, T.R.row2.z};
      if (link.type == JointType::kPrismatic) T.p = T.p + at.s * z;
      if (tree.independent && tree.coefficient[link.first_coefficient].coefficient != 1.0)
        z = static_cast<C>(tree.coefficient[link.first_coefficient].coefficient) * z;
      if (link.type == JointType::kPrismatic) {
        set(kAxis, k, {recursion_detail::zero3<S>(), z});
      } else {
        set(kAxis, k, {z, cross(T.p, z)});
      }
    }
  }

  /// Computes the links' own inertias; see link_inertias() for their zeros.
  void inertias(const Links& tree, const LinkInertia* inertia) const {
    using C = typename ConstantOf<S>::type;
    const auto c = [](double x) { return static_cast<C>(x); };
    for (int k = 0; k < tree.count; ++k) {
      const LinkInertia& I = inertia[k];
      const Mat3<S>& R = pose[k].R;
      const Vec3<S>& p = pose[k].p;
      Vec3<S> h;
      S m(0.0);
      Vec3<S> x, y, z;  // rows of the second moments
      if (tree.link[k].type == JointType::kPrismatic) {
        m = S(c(I.m));
        h = rotate(R, constant<S>(I.h));
        const Vec3<S> mp = m * p;
        const Vec3<S> s = h + mp;
        x = p.x * s + h.x * p;
        y = p.y * s + h.y * p;
        z = p.z * s + h.z * p;
        h = s;
      } else {
        const auto moments = [&](const Vec3<S>& r) {
          return Vec3<S>{c(I.xx) * r.x + c(I.xy) * r.y + c(I.xz) * r.z,
                         c(I.xy) * r.x + c(I.yy) * r.y + c(I.yz) * r.z,
                         c(I.xz) * r.x + c(I.yz) * r.y};
        };
        const auto first = [&](const Vec3<S>& r) { return c(I.h.x) * r.x + c(I.h.y) * r.y; };
        h = {first(R.row0), first(R.row1), first(R.row2)};
        x = rotate(R, moments(R.row0)) + p.x * h + h.x * p;
        y = rotate(R, moments(R.row1)) + p.y * h + h.y * p;
        z = rotate(R, moments(R.row2)) + p.z * h + h.z * p;
      }
      S* to = array(kInertia) + k;
      const S all[] = {m, h.x, h.y, h.z, x.x, x.y, y.y, x.z, y.z, z.z};
      for (int e = 0; e < 10; ++e) to[e * stride] = all[e];
    }
  }

  /// Computes velocities, rates of the axes and momenta of the links.
  void velocities(const Links& tree, const S* dq) const {
    for (int k = 0; k < tree.count; ++k) {
      const int parent = tree.link[k].parent;
      const Screw<S> own = joint_value(tree, k, dq) * screw(kAxis, k);
      set(kVelocity, k, parent < 0 ? own : screw(kVelocity, parent) + own);
    }
    for (int g = 0; g < groups(tree.count); ++g) {
      const Screw<L> velocity = lane_screw(kVelocity, g);
      set_lanes(kDrift, g, cross(velocity, lane_screw(kAxis, g)));
      const Momentum<L> c = momentum(lane_inertia(g), velocity);
      set_lanes(kMomentum, g, c.p);
      set_lanes(kMomentum + 3, g, c.W.row0);
      set_lanes(kMomentum + 6, g, c.W.row1);
      set_lanes(kMomentum + 9, g, c.W.row2);
    }
  }

  /// Computes accelerations, their changes by the joints' positions and the wrenches that they need.
  void accelerations(const Links& tree, const S* dq, const S* ddq) const {
    const auto up = constant<S>(Vec3d{-tree.gravity.x, -tree.gravity.y, -tree.gravity.z});
    const Screw<S> rest{recursion_detail::zero3<S>(), {S(up.x), S(up.y), S(up.z)}};
    for (int k = 0; k < tree.count; ++k) {
      const int parent = tree.link[k].parent;
      const Screw<S> own = joint_value(tree, k, ddq) * screw(kAxis, k) +
                           joint_value(tree, k, dq) * screw(kDrift, k);
      set(kAcceleration, k, (parent < 0 ? rest : screw(kAcceleration, parent)) + own);
    }
    using C = typename ConstantOf<S>::type;
    const L half(static_cast<C>(0.5));
    for (int g = 0; g < groups(tree.count); ++g) {
      const Screw<L> a = lane_screw(kAcceleration, g);
      const Screw<L> v = lane_screw(kVelocity, g);
      set_lanes(kTurn, g,
                half * (cross(a, lane_screw(kAxis, g)) + cross(v, lane_screw(kDrift, g))));
      set_lanes(kWrench, g, wrench(lane_inertia(g), a) + wrench(lane_momentum(g), v.w));
    }
  }

  /// Adds the arrays first .. end - 1 of each link to those of its parent.
  void sum_over_subtrees(const Links& tree, int first, int end) const {
    for (int k = tree.count - 1; k > 0; --k) {
      const int parent = tree.link[k].parent;
      if (parent < 0) continue;
      for (int e = first; e < end; ++e) data[e * stride + parent] += data[e * stride + k];
    }
  }

  // The functions below need the sums of sum_over_subtrees().

  /// Computes kForce.
  void forces(const Links& tree) const {
    for (int g = 0; g < groups(tree.count); ++g)
      set_lanes(kForce, g, wrench(lane_inertia(g), lane_screw(kAxis, g)));
  }

  /// Computes kSpin and kByVelocity. A small motion of a joint adds a + 2 w x xdot to the acceleration at x of all that it carries:
  /// one motion of one composite body.
  void changes_by_velocity(const Links& tree) const {
    for (int g = 0; g < groups(tree.count); ++g) {
      const Screw<L> axis = lane_screw(kAxis, g);
      const Momentum<L> c = lane_momentum(g);
      set_lanes(kSpin, g, spin_of(c, axis));
      set_lanes(kByVelocity, g,
                wrench(lane_inertia(g), lane_screw(kDrift, g)) + wrench(c, axis.w));
    }
  }
  /// Computes kByPosition; needs accelerations().
  void changes_by_position(const Links& tree) const {
    using C = typename ConstantOf<S>::type;
    const L half(static_cast<C>(0.5));
    for (int g = 0; g < groups(tree.count); ++g) {
      set_lanes(kByPosition, g,
                wrench(lane_inertia(g), lane_screw(kTurn, g)) +
                    wrench(lane_momentum(g), lane_vector(kDrift, g)) +
                    half * cross_wrench(lane_screw(kAxis, g), lane_screw(kWrench, g)));
    }
  }

  /// The torque of link k's joint under the wrench kWrench.
  S torque(int k) const { return dot(screw(kAxis, k), screw(kWrench, k)); }

  /// Quantities whose products are the entries of a matrix: the screw `row` of the row's link times the screw
  /// `column` of the column's link, and two vectors in the same way, unless their indices are negative.
  struct Products {
    int row, column;
    int row_vector = -1, column_vector = -1;
  };

  /// Computes a matrix over pairs of links: `upper` where the row's link carries the column's or is
  /// the same, `lower` where it is carried by it, 0 where none carries the other.
  ///
  /// @param to  column by column, `ld` entries apart. kTransposed: row by row.
  template <bool kTransposed, bool kVectors>
  void write_pair_products(const Links& tree, const Products& upper, const Products& lower, const S& scale,
                           S* to, int ld) const {
    const int count = tree.count;
    const int width = groups(count);
    for (int fixed = 0; fixed < count; ++fixed) {
      const Screw<S> before = scale * screw(kTransposed ? lower.row : upper.column, fixed);
      const Screw<S> behind = scale * screw(kTransposed ? upper.row : lower.column, fixed);
      const int before_lanes = kTransposed ? lower.column : upper.row;
      const int behind_lanes = kTransposed ? upper.column : lower.row;
      Vec3<S> spin;
      if constexpr (kVectors)
        spin = scale * vector(kTransposed ? lower.row_vector : lower.column_vector, fixed);
      const int spin_lanes = kTransposed ? lower.column_vector : lower.row_vector;
      const auto at_before = [&](int g) {
        L sum = dot(before, lane_screw(before_lanes, g));
        if constexpr (kVectors && kTransposed) sum += dot(spin, lane_vector(spin_lanes, g));
        return sum;
      };
      const auto at_behind = [&](int g) {
        L sum = dot(behind, lane_screw(behind_lanes, g));
        if constexpr (kVectors && !kTransposed) sum += dot(spin, lane_vector(spin_lanes, g));
        return sum;
      };
      const int own = fixed / lanes();
      S* const column = to + long{fixed} * ld;
      // Whole packs are stored where their surplus lanes fall into what is computed later, not behind the matrix.
      const int room = (count - fixed) * ld - own * lanes();
      const int left = room < lanes() ? room : lanes();
      for (int g = 0; g < own; ++g) store(at_before(g), lanes(), column + g * lanes());
      store(first_lanes(fixed % lanes(), at_before(own), at_behind(own)), left,
            column + own * lanes());
      for (int g = own + 1; g < width; ++g) store(at_behind(g), lanes(), column + g * lanes());
    }
    for (int e = 0; e < tree.strangers; ++e) {
      const LinkPair& pair = tree.stranger[e];
      to[pair.first + long{pair.second} * ld] = to[pair.second + long{pair.first} * ld] = S(0.0);
    }
  }

  /// Lanes 0 .. last of a, the others of b.
  static L first_lanes(int last, const L& a, const L& b) {
    if constexpr (kWide) {
      return L(lane_index() <= static_cast<long long>(last) ? a.v : b.v);
    } else {
      return last >= 0 ? a : b;
    }
  }
  static auto lane_index() {  // not an array, since lanes that are set one by one go through memory
    typename L::Mask index;
    for (int l = 0; l < lanes(); ++l) index[l] = l;
    return index;
  }

  // ---- articulated bodies ------------------------------------------------------------------------

  /// Factors the mass matrix of independent joints in O(links); needs inertias() without sum_over_subtrees().
  /// False if it is not positive definite.
  bool articulate(const Links& tree) const {
    const S none(0.0);
    for (int k = 0; k < tree.count; ++k) {
      const S* I = array(kInertia) + k;
      const S& m = I[0];
      const Vec3<S> h = vector(kInertia + 1, k);
      const S &xx = I[4 * stride], &yy = I[6 * stride], &zz = I[9 * stride];
      articulated[k].J = {yy + zz, -I[5 * stride], xx + zz, -I[7 * stride], -I[8 * stride], xx + yy};
      articulated[k].H = {{none, -h.z, h.y}, {h.z, none, -h.x}, {-h.y, h.x, none}};
      articulated[k].M = {m, none, m, none, none, m};
    }
    for (int k = tree.count - 1; k >= 0; --k) {
      const ArticulatedInertia<S>& A = articulated[k];
      const Screw<S> axis = screw(kAxis, k);
      const Screw<S> U{rotate(A.J, axis.w) + rotate(A.H, axis.v),
                       rotate_back(A.H, axis.w) + rotate(A.M, axis.v)};
      const S pivot = dot(axis, U);
      if (!is_positive(pivot)) return false;
      const S inverse = S(1.0) / pivot;
      const Screw<S> u = inverse * U;
      joint[k] = {axis, u, recursion_detail::zero3<S>(), inverse};
      const int parent = tree.link[k].parent;
      if (parent < 0) continue;
      ArticulatedInertia<S>& to = articulated[parent];
      add_reduced(A.J, U.w, u.w, to.J);
      to.H.row0 = to.H.row0 + A.H.row0 - U.w.x * u.v;
      to.H.row1 = to.H.row1 + A.H.row1 - U.w.y * u.v;
      to.H.row2 = to.H.row2 + A.H.row2 - U.w.z * u.v;
      add_reduced(A.M, U.v, u.v, to.M);
    }
    return true;
  }

  /// Turns efforts x, one per link, into the accelerations from rest; needs articulate(). @param memory  one per link.
  void solve(const Links& tree, S* x, Screw<S>* memory) const {
    for (int k = 0; k < tree.count; ++k) memory[k] = none<S>();
    for (int k = tree.count - 1; k >= 0; --k) {
      x[k] = x[k] + dot(joint[k].axis, memory[k]);
      const int parent = tree.link[k].parent;
      if (parent >= 0) memory[parent] = memory[parent] + memory[k] - x[k] * joint[k].reduced;
    }
    for (int k = 0; k < tree.count; ++k) {
      const int parent = tree.link[k].parent;
      const Screw<S> a = parent < 0 ? none<S>() : memory[parent];
      x[k] = joint[k].inverse * x[k] - dot(joint[k].reduced, a);
      memory[k] = a + x[k] * joint[k].axis;
    }
  }

  /// Prepares respond_to_motion(): a motion of joint k acts on the joints above it like one wrench on its
  /// link, on those that it carries like an acceleration of the link and a rotation at a velocity.
  /// Needs articulate(), own momenta, and kWrench summed up.
  void articulated_changes(const Links& tree) const {
    using C = typename ConstantOf<S>::type;
    const S half(static_cast<C>(0.5));
    for (int k = 0; k < tree.count; ++k) {
      const S* c = array(kMomentum) + k;
      const S &px = c[0], &py = c[stride], &pz = c[2 * stride];
      const auto W = [&](int e) -> const S& { return c[(3 + e) * stride]; };
      const S zero(0.0);
      articulated[k].spin_moment = {{W(4) + W(8), -W(3), -W(6)},
                                    {-W(1), W(0) + W(8), -W(7)},
                                    {-W(2), -W(5), W(0) + W(4)}};
      articulated[k].spin_force = {{zero, pz, -py}, {-pz, zero, px}, {py, -px, zero}};
    }
    for (int k = tree.count - 1; k >= 0; --k) {
      const ArticulatedInertia<S>& A = articulated[k];
      const Screw<S>& axis = joint[k].axis;
      const Screw<S>& reduced = joint[k].reduced;
      const Vec3<S> spin =
          rotate_back(A.spin_moment, axis.w) + rotate_back(A.spin_force, axis.v);
      joint[k].spin = spin;
      const auto begin = [&](const Screw<S>& f, int wrench, int torque) {
        const S effort = dot(axis, f);
        array(torque)[k] = effort;
        set(wrench, k, f - effort * reduced);
      };
      const auto resistance = [&](const Screw<S>& a, const Vec3<S>& w) {
        return Screw<S>{rotate(A.J, a.w) + rotate(A.H, a.v) + rotate(A.spin_moment, w),
                        rotate_back(A.H, a.w) + rotate(A.M, a.v) + rotate(A.spin_force, w)};
      };
      begin(resistance(screw(kTurn, k), vector(kDrift, k)) +
                half * cross_wrench(axis, screw(kWrench, k)),
            kByPosition, kTorqueByPosition);
      begin(resistance(screw(kDrift, k), axis.w), kByVelocity, kTorqueByVelocity);
      const int parent = tree.link[k].parent;
      if (parent < 0) continue;
      const auto carry_up = [&](const Vec3<S>& by, const Mat3<S>& from, Mat3<S>& to) {
        to.row0 = to.row0 + from.row0 - by.x * spin;
        to.row1 = to.row1 + from.row1 - by.y * spin;
        to.row2 = to.row2 + from.row2 - by.z * spin;
      };
      carry_up(reduced.w, A.spin_moment, articulated[parent].spin_moment);
      carry_up(reduced.v, A.spin_force, articulated[parent].spin_force);
    }
  }

  /// Quantities that are passed from link to link.
  struct Response {
    Screw<L> at;
    Vec3<L> spin;
  };

  /// Computes -1/2 times the derivatives of all joints' accelerations with respect to the positions and velocities of
  /// group g, both side by side, since each step waits for the one before. Needs articulated_changes().
  ///
  /// @param x  one entry per link, `width` apart; accelerations by velocity are groups(links) later.
  void respond_to_motion(const Links& tree, int g, int width, L* x, Response* memory) const {
    const int first = g * lanes();
    const int end = first + lanes() < tree.count ? first + lanes() : tree.count;
    Response* const other = memory + tree.count;
    L* const y = x + groups(tree.count);
    clear_forks(tree, end, memory);
    clear_forks(tree, end, other);
    Screw<L> f = none<L>();
    Screw<L> h = none<L>();
    for (int k = end - 1; k >= 0; --k) {
      const int lane = k - first;
      x[long{k} * width] = pass_wrench_to_parent(tree, k, lane, kPosition, f, memory);
      y[long{k} * width] = pass_wrench_to_parent(tree, k, lane, kRate, h, other);
    }
    Response r = zero_response();
    Response s = zero_response();
    for (int k = 0; k < tree.count; ++k) {
      pass_acceleration_to_children(tree, k, first, end, kPosition, x[long{k} * width], r, memory);
      pass_acceleration_to_children(tree, k, first, end, kRate, y[long{k} * width], s, other);
    }
  }

  /// Computes derivatives with respect to the torques of group g: those of the accelerations of all joints up to
  /// the group's last. Needs articulate(). @param x  one entry per link, `width` apart.
  void respond_to_torque(const Links& tree, int g, int width, L* x, Response* memory) const {
    const int first = g * lanes();
    const int end = first + lanes() < tree.count ? first + lanes() : tree.count;
    clear_forks(tree, end, memory);
    Screw<L> f = none<L>();
    for (int k = end - 1; k >= 0; --k)
      x[long{k} * width] = pass_wrench_to_parent(tree, k, k - first, kTorque, f, memory);
    Response r = zero_response();
    for (int k = 0; k < end; ++k)
      pass_acceleration_to_children(tree, k, first, end, kTorque, x[long{k} * width], r, memory);
  }

 private:
  /// Derivatives by a joint's position: for the links above it and for those that it carries.
  struct Position {
    static constexpr int torque = kTorqueByPosition, wrench = kByPosition, acceleration = kTurn,
                         spin = kDrift;
  };
  struct Rate {
    static constexpr int torque = kTorqueByVelocity, wrench = kByVelocity, acceleration = kDrift,
                         spin = kAxis;
  };
  struct Torque {};
  static constexpr Position kPosition{};
  static constexpr Rate kRate{};
  static constexpr Torque kTorque{};

  static Response zero_response() { return {none<L>(), recursion_detail::zero3<L>()}; }
  /// Sets the responses of those links 0 .. end - 1 that fork to zero.
  static void clear_forks(const Links& tree, int end, Response* memory) {
    for (int k = 0; k < end; ++k) {
      if (tree.link[k].forks) memory[k] = zero_response();
    }
  }

  /// Passes the wrench f of the links that link k carries on to its parent. @returns the effort of
  /// its joint. @param lane  of this joint, if it is not negative.
  template <typename Cause>
  L pass_wrench_to_parent(const Links& tree, int k, int lane, const Cause&, Screw<L>& f,
                          Response* memory) const {
    const Link& link = tree.link[k];
    const Screw<S>& axis = joint[k].axis;
    const Screw<S>& reduced = joint[k].reduced;
    if (link.forks) f = f + memory[k].at;
    L u = dot(axis.w, f.w) + dot(axis.v, f.v);
    f = {f.w - u * reduced.w, f.v - u * reduced.v};
    if (lane >= 0) {
      if constexpr (std::is_same<Cause, Torque>::value) {
        put_lane(lane, S(1.0), u);
        put_lane(lane, none<S>() - reduced, f);
      } else {
        put_lane(lane, array(Cause::torque)[k], u);
        put_lane(lane, screw(Cause::wrench, k), f);
      }
    }
    if (link.parent == k - 1) return u;
    if (link.parent >= 0) memory[link.parent].at = memory[link.parent].at + f;
    f = none<L>();
    return u;
  }

  /// Computes the acceleration u of joint k, from its effort, and what link k passes on.
  template <typename Cause>
  void pass_acceleration_to_children(const Links& tree, int k, int first, int end, const Cause&, L& u, Response& r,
                                     Response* memory) const {
    const Link& link = tree.link[k];
    const Screw<S>& axis = joint[k].axis;
    const Screw<S>& reduced = joint[k].reduced;
    if (link.parent != k - 1) r = link.parent < 0 ? zero_response() : memory[link.parent];
    L effort(0.0);
    if (k < end) effort = u;
    if constexpr (!std::is_same<Cause, Torque>::value) effort += dot(joint[k].spin, r.spin);
    const L acceleration = joint[k].inverse * effort - reduced.w.x * r.at.w.x -
                           reduced.w.y * r.at.w.y - reduced.w.z * r.at.w.z -
                           dot(reduced.v, r.at.v);
    u = acceleration;
    r.at = {r.at.w + acceleration * axis.w, r.at.v + acceleration * axis.v};
    if constexpr (!std::is_same<Cause, Torque>::value) {
      if (k >= first && k < end) {
        Screw<L> moved = none<L>();
        put_lane(k - first, screw(Cause::acceleration, k), moved);
        r.at = r.at - moved;
        put_lane(k - first, vector(Cause::spin, k), r.spin);
      }
    }
    if (link.forks) memory[k] = r;
  }

  template <typename X>
  static Screw<X> none() {
    return {recursion_detail::zero3<X>(), recursion_detail::zero3<X>()};
  }
  /// Sets one lane of `to`; without packs, all of it.
  static void put_lane(int lane, const S& from, L& to) {
    if constexpr (kWide) {
      to = L(lane_index() == static_cast<long long>(lane) ? L(from).v : to.v);
    } else {
      to = from;
    }
  }
  static void put_lane(int lane, const Vec3<S>& from, Vec3<L>& to) {
    put_lane(lane, from.x, to.x);
    put_lane(lane, from.y, to.y);
    put_lane(lane, from.z, to.z);
  }
  static void put_lane(int lane, const Screw<S>& from, Screw<L>& to) {
    put_lane(lane, from.w, to.w);
    put_lane(lane, from.v, to.v);
  }
};

}  // namespace veridyn
