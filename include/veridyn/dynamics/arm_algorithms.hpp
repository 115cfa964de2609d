#pragma once

#include <type_traits>
#include <vector>

#include "veridyn/dynamics/recursion.hpp"

namespace veridyn {

/// A tree of moving links with its inertias, see link_inertias().
struct InertialLinks {
  Links tree;
  const LinkInertia* inertia;  ///< null where only motion and regressor are computed
};

// True if a pivot is above zero. Symbolic scalars cannot be compared; their pivots count as
// positive.
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

/// Rigid-body dynamics at one state over any scalar S. Columns of matrices are computed side by
/// side in the lanes of L: a pack of S, or S itself for one at a time. Vectors hold n entries;
/// matrices (n x n) are column-major without gaps. All functions work in the caller's memory, see
/// ArmDynamics.
template <typename S, typename L = S>
struct ArmAlgorithms {
  static constexpr bool kWide = !std::is_same<S, L>::value;

  static constexpr int lanes() {
    if constexpr (kWide) return L::kSize;
    return 1;
  }

  struct Memory {
    LinkState<S>* state;
    Tangent<L>* tangent;
    Column<L>* column;
    InertiaOf<S>* carried;  ///< inertia of each link with all links that it carries
    CarriedMomentum<S>* momentum;
    L* angle;    ///< all angles, then sines, then cosines
    L* rows;     ///< rows of 2 n columns
    L* inverse;  ///< n rows of n columns
    S* vector;   ///< n entries
    S* matrix;   ///< n x n entries
  };

  static int groups(int columns) { return (columns + lanes() - 1) / lanes(); }

  /// Size of the workspace in bytes, and its parts; align it for L.
  static std::size_t workspace(const Links& tree) {
    Parts parts{nullptr};
    divide(tree, parts);
    return parts.used;
  }
  static Memory divide(const Links& tree, void* memory) {
    Parts parts{static_cast<char*>(memory)};
    return divide(tree, parts);
  }

  // ---- motion and torques ------------------------------------------------------------------------

  /// Computes joint variables, sines, cosines and rotations; a null pointer counts as zeros.
  static void place(const Links& tree, const S* q, const S* dq, const S* ddq, const Memory& at) {
    if constexpr (!kWide) return joint_pass(tree, q, dq, ddq, {at.state, nullptr});
    if constexpr (kWide) {
      for (int k = 0; k < tree.count; ++k) {
        joint_variable(tree, tree.link[k], q, dq, ddq, at.state[k]);
        at.angle[k / lanes()].v[k % lanes()] = at.state[k].s.v;
      }
      sines(tree, at);
    }
  }

  /// Computes velocities, accelerations and the forces that they require.
  static void motion(const InertialLinks& arm, const Memory& at) {
    const Workspace<S> r{at.state, nullptr};
    for (int k = 0; k < arm.tree.count; ++k) {
      forward_step(arm.tree, k, arm.tree.gravity, r);
      if (arm.inertia == nullptr) continue;
      LinkState<S>& state = at.state[k];
      link_wrench(arm.tree.link[k], arm.inertia[k], state.accel, state.E, state.force,
                  state.moment);
    }
  }

  /// Computes g: all links have one linear acceleration, opposite to gravity, and no angular one.
  static void gravity_torques(const InertialLinks& arm, const S* q, S* g, const Memory& at) {
    const Vec3d& down = arm.tree.gravity;
    using C = typename ConstantOf<S>::type;
    const Vec3<S> up{S(static_cast<C>(-down.x)), S(static_cast<C>(-down.y)),
                     S(static_cast<C>(-down.z))};
    place(arm.tree, q, nullptr, nullptr, at);
    for (int k = 0; k < arm.tree.count; ++k) {
      const Link& link = arm.tree.link[k];
      LinkState<S>& state = at.state[k];
      state.accel = to_joint(link, state.R, link.parent < 0 ? up : at.state[link.parent].accel);
      const auto h = constant<S>(arm.inertia[k].h);
      state.force = static_cast<C>(arm.inertia[k].m) * state.accel;
      state.moment = cross(h, state.accel);
    }
    backward_pass(arm.tree, {at.state, nullptr}, g);
  }

  /// tau = M ddq + C dq + g minus the torques of the external wrenches; a null ddq counts as zeros.
  static void inverse_dynamics(const InertialLinks& arm, const S* q, const S* dq, const S* ddq,
                               const LinkWrench* external, int externals, S* tau,
                               const Memory& at) {
    place(arm.tree, q, dq, ddq, at);
    motion(arm, at);
    for (int e = 0; e < externals; ++e) {
      LinkState<S>& state = at.state[external[e].link];
      state.force = state.force - constant<S>(external[e].force);
      state.moment = state.moment - constant<S>(external[e].moment);
    }
    backward_pass(arm.tree, {at.state, nullptr}, tau);
  }

  static void mass_matrix(const InertialLinks& arm, const S* q, S* M, const Memory& at) {
    place(arm.tree, q, nullptr, nullptr, at);
    mass_of(arm, M, at);
  }

  /// Computes M from the inertias that the links carry (Featherstone, ch. 6.2); needs place().
  static void mass_of(const InertialLinks& arm, S* M, const Memory& at) {
    const Links& tree = arm.tree;
    for (int k = 0; k < tree.count; ++k) at.carried[k] = own_inertia(arm, k);
    const int n = tree.joints;
    const int width = groups(n);
    for (int e = 0; e < n * width; ++e) at.inverse[e] = L(0.0);
    for (int g = 0; g < width; ++g) mass_columns(tree, g, width, at);
    const auto entry = [&](int i, int j) -> S {
      const L& from = at.inverse[i * width + j / lanes()];
      if constexpr (kWide) return from.v[j % lanes()];
      if constexpr (!kWide) return from;
    };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j <= i; ++j) M[i * n + j] = M[j * n + i] = entry(i, j) + entry(j, i);
    }
  }

  /// The inertia of link k alone.
  static InertiaOf<S> own_inertia(const InertialLinks& arm, int k) {
    const LinkInertia& I = arm.inertia[k];
    const auto c = [](double x) { return S(static_cast<typename ConstantOf<S>::type>(x)); };
    return {c(I.m),  {c(I.h.x), c(I.h.y), c(I.h.z)}, c(I.xx), c(I.xy), c(I.yy),
            c(I.xz), c(I.yz), c(I.zz)};
  }

  /// Computes M and h = C dq + g.
  static void equation_of_motion(const InertialLinks& arm, const S* q, const S* dq, S* M, S* h,
                                 const Memory& at) {
    inverse_dynamics(arm, q, dq, nullptr, nullptr, 0, h, at);
    mass_of(arm, M, at);
  }

  /// Computes M and h, where they are not null, and D = scale * dh/d(dq): with 1/2 the Coriolis
  /// matrix of Christoffel's symbols, for which dM/dt - 2 C is skew.
  static void velocity_derivative(const InertialLinks& arm, const S* q, const S* dq, double scale,
                                  S* M, S* h, S* D, const Memory& at) {
    const int n = arm.tree.joints;
    inverse_dynamics(arm, q, dq, nullptr, nullptr, 0, h == nullptr ? at.vector : h, at);
    if (M != nullptr) mass_of(arm, M, at);
    rows_along<kOfVelocity>(arm, n, at.rows, at);
    columns(n, groups(n), 0, n, S(static_cast<typename ConstantOf<S>::type>(scale)), at.rows, D);
  }

  /// Computes dL/dq = C' dq - g of the Lagrangian L = dq' M dq / 2 - U in O(links): with the momentum
  /// (p, l) and the gravity of all that a joint carries, dL/dq = z . (p x v + l x w + h x g) where it
  /// turns and z . (p x w + m g) where it slides, v and w the velocities of its link.
  static void lagrangian_gradient(const InertialLinks& arm, const S* q, const S* dq, S* gradient,
                                  const Memory& at) {
    const Links& tree = arm.tree;
    const Vec3d& g = tree.gravity;
    place(tree, q, dq, nullptr, at);
    for (int k = 0; k < tree.count; ++k) {
      const Link& link = tree.link[k];
      LinkState<S>& state = at.state[k];
      Vec3<S>& w = state.omega;
      Vec3<S>& v = state.accel;  // velocity of the origin
      Vec3<S>& down = state.alpha;
      w = v = recursion_detail::zero3<S>();
      if (link.parent >= 0) {
        const LinkState<S>& above = at.state[link.parent];
        v = above.accel;
        if (link.A_moves) v = v + cross(above.omega, constant<S>(link.A.p));
        v = to_joint(link, state.R, v);
        w = to_joint(link, state.R, above.omega);
        down = to_joint(link, state.R, above.alpha);
      } else {
        down = rotate_back(state.R, constant<S>(g));
      }
      if (link.type == JointType::kRevolute) {
        w.z += state.ds;
      } else {
        v.x += state.s * w.y;
        v.y -= state.s * w.x;
        v.z += state.ds;
      }
      const InertiaOf<S> I = at.carried[k] = own_inertia(arm, k);
      state.force = I.m * v + cross(w, I.h);
      state.moment = cross(I.h, v);
      state.moment.x += (I.yy + I.zz) * w.x - I.xy * w.y - I.xz * w.z;
      state.moment.y += (I.xx + I.zz) * w.y - I.xy * w.x - I.yz * w.z;
      state.moment.z += (I.xx + I.yy) * w.z - I.xz * w.x - I.yz * w.y;
    }
    for (int i = 0; i < tree.joints; ++i) gradient[i] = S(0.0);
    for (int k = tree.count - 1; k >= 0; --k) {
      const Link& link = tree.link[k];
      const LinkState<S>& state = at.state[k];
      InertiaOf<S>& I = at.carried[k];  // of the carried sum only m and h are kept up
      const Vec3<S>& w = state.omega;
      S effort = state.force.x * w.y - state.force.y * w.x + I.m * state.alpha.z;
      if (link.type == JointType::kRevolute) {
        effort = state.force.x * state.accel.y - state.force.y * state.accel.x +
                 state.moment.x * w.y - state.moment.y * w.x + I.h.x * state.alpha.y -
                 I.h.y * state.alpha.x;
      } else {
        I.h.z += state.s * I.m;
      }
      for (int e = link.first_coefficient; e < link.end_coefficient; ++e) {
        const JointCoefficient& c = tree.coefficient[e];
        gradient[c.coordinate] += static_cast<typename ConstantOf<S>::type>(c.coefficient) * effort;
      }
      if (link.parent < 0) continue;
      carry_force(link, state, at.state[link.parent]);
      InertiaOf<S>& above = at.carried[link.parent];
      above.m += I.m;
      above.h = above.h + from_joint(link, state.R, I.h) + I.m * constant<S>(link.A.p);
    }
  }

  /// Computes tau and its derivatives by q, dq and ddq, the last of which is M.
  static void derivatives(const InertialLinks& arm, const S* q, const S* dq, const S* ddq, S* tau,
                          S* by_q, S* by_dq, S* M, const Memory& at) {
    const int n = arm.tree.joints;
    inverse_dynamics(arm, q, dq, ddq, nullptr, 0, tau, at);
    if constexpr (kWide) {
      mass_of(arm, M, at);
      rows_along<kOfPosition | kOfVelocity>(arm, 2 * n, at.rows, at);
      columns(n, groups(2 * n), 0, n, S(1.0), at.rows, by_q);
      columns(n, groups(2 * n), n, 2 * n, S(1.0), at.rows, by_dq);
    } else {
      by_pairs(arm, by_q, by_dq, M, at);
    }
  }

  /// Computes the derivatives joint by joint from closed forms; requires backward_pass(). This takes
  /// 0.6 times the operations of tangents, but few of them side by side.
  static void by_pairs(const InertialLinks& arm, S* by_q, S* by_dq, S* M, const Memory& at) {
    const Links& tree = arm.tree;
    const int n = tree.joints;
    const Vec3<S> none = recursion_detail::zero3<S>();
    for (int e = 0; e < n * n; ++e) by_q[e] = by_dq[e] = M[e] = S(0.0);
    for (int k = 0; k < tree.count; ++k) {
      at.carried[k] = own_inertia(arm, k);
      at.momentum[k] = {none, {none, none, none}};
    }
    for (int k = tree.count - 1; k >= 0; --k) {
      const Link& link = tree.link[k];
      if (link.parent >= 0) {
        carry_inertia(link, at.state[k], at.carried[k], at.carried[link.parent]);
        carry_momentum(link, at.state[k], at.carried[k], at.momentum[k], at.momentum[link.parent]);
      }
      JointForces<S> t;
      joint_forces(link, at.state[k], at.carried[k], at.momentum[k], t);
      for (int j = k; j >= 0; j = tree.link[j].parent) {
        const Link& above = tree.link[j];
        const LinkState<S>& state = at.state[j];
        const auto add = [&](const S& torque_j, const S& torque_k, S* to) {
          using C = typename ConstantOf<S>::type;
          for (int e = link.first_coefficient; e < link.end_coefficient; ++e) {
            for (int f = above.first_coefficient; f < above.end_coefficient; ++f) {
              const JointCoefficient& a = tree.coefficient[e];
              const JointCoefficient& b = tree.coefficient[f];
              const C both = static_cast<C>(a.coefficient * b.coefficient);
              to[b.coordinate * n + a.coordinate] += both * torque_k;
              if (j != k) to[a.coordinate * n + b.coordinate] += both * torque_j;
            }
          }
        };
        const S twice_x = state.omega.x + state.omega.x;
        const S twice_y = state.omega.y + state.omega.y;
        if (above.type == JointType::kRevolute) {
          add(t.moment.z, t.moment.z, M);
          add(t.position_moment.z,
              dot(state.E.z, t.moment) + state.accel.y * t.force.x - state.accel.x * t.force.y +
                  state.omega.y * t.spin.x - state.omega.x * t.spin.y,
              by_q);
          add(t.velocity_moment.z, twice_y * t.moment.x - twice_x * t.moment.y + t.spin.z, by_dq);
        } else {
          add(t.force.z, t.force.z, M);
          add(t.position_force.z, dot(state.E.z, t.force), by_q);
          add(t.velocity_force.z, twice_y * t.force.x - twice_x * t.force.y, by_dq);
        }
        if (above.parent >= 0) to_parent(above, state, at.state[above.parent].omega, t);
      }
    }
  }

  // ---- forward dynamics --------------------------------------------------------------------------

  /// Solves for ddq of tau; leaves M factored. False if M is not positive definite.
  static bool forward_dynamics(const InertialLinks& arm, const S* q, const S* dq, const S* tau,
                               S* ddq, S* M, const Memory& at) {
    const int n = arm.tree.joints;
    equation_of_motion(arm, q, dq, M, at.vector, at);
    for (int i = 0; i < n; ++i) at.vector[i] = tau[i] - at.vector[i];
    if (!factor(n, M)) return false;
    solve(n, M, 1, at.vector);
    for (int i = 0; i < n; ++i) ddq[i] = at.vector[i];
    return true;
  }

  /// Computes ddq and its derivatives by q, dq and tau: -M^-1 dtau/dx at that ddq, and M^-1.
  static bool forward_derivatives(const InertialLinks& arm, const S* q, const S* dq, const S* tau,
                                  S* ddq, S* by_q, S* by_dq, S* by_tau, const Memory& at) {
    const int n = arm.tree.joints;
    if (!forward_dynamics(arm, q, dq, tau, ddq, at.matrix, at)) return false;
    for (int k = 0; k < arm.tree.count; ++k)
      at.state[k].dds = along_joint(arm.tree, arm.tree.link[k], ddq);
    motion(arm, at);
    backward_pass(arm.tree, {at.state, nullptr}, at.vector);
    const int wide = groups(2 * n);
    rows_along<kOfPosition | kOfVelocity>(arm, 2 * n, at.rows, at);
    solve(n, at.matrix, wide, at.rows);
    columns(n, wide, 0, n, S(-1.0), at.rows, by_q);
    columns(n, wide, n, 2 * n, S(-1.0), at.rows, by_dq);
    const int narrow = groups(n);
    for (int e = 0; e < n * narrow; ++e) at.inverse[e] = L(0.0);
    for (int i = 0; i < n; ++i) {
      L& unit = at.inverse[i * narrow + i / lanes()];
      if constexpr (kWide) unit.v[i % lanes()] = 1.0;
      if constexpr (!kWide) unit = S(1.0);
    }
    solve(n, at.matrix, narrow, at.inverse);
    columns(n, narrow, 0, n, S(1.0), at.inverse, by_tau);
    return true;
  }

  /// Factors M = L D L' in place: L below the diagonal, 1 / D on it. False if M is not positive
  /// definite.
  static bool factor(int n, S* M) {
    for (int j = 0; j < n; ++j) {
      S* column = M + j * n;
      if (!is_positive(column[j])) return false;
      const S inverse = S(1.0) / column[j];
      for (int k = j + 1; k < n; ++k) {
        const S share = column[k] * inverse;
        S* next = M + k * n;
        for (int i = k; i < n; ++i) next[i] -= share * column[i];
      }
      column[j] = inverse;
      for (int i = j + 1; i < n; ++i) column[i] = column[i] * inverse;
    }
    return true;
  }

  /// Solves M^-1 X in place with a factored M; X has n rows of `width` entries.
  template <typename X>
  static void solve(int n, const S* M, int width, X* x) {
    for (int j = 0; j < n; ++j) {
      for (int i = j + 1; i < n; ++i) {
        for (int g = 0; g < width; ++g) x[i * width + g] -= M[j * n + i] * x[j * width + g];
      }
    }
    for (int j = n - 1; j >= 0; --j) {
      for (int g = 0; g < width; ++g) {
        X sum = M[j * n + j] * x[j * width + g];
        for (int i = j + 1; i < n; ++i) sum -= M[j * n + i] * x[i * width + g];
        x[j * width + g] = sum;
      }
    }
  }

  // ---- derivatives in lanes ----------------------------------------------------------------------

  /// Derivatives of the torques along the first `count` directions of the state space, in rows: row
  /// i, which is torque i, has groups(count) entries. Needs motion() and backward_pass().
  /// kOfPosition | kOfVelocity: 2 n directions, those of q before those of dq; kOfVelocity: n.
  template <unsigned kOf>
  static void rows_along(const InertialLinks& arm, int count, L* rows, const Memory& at) {
    const int width = groups(count);
    for (int e = 0; e < arm.tree.joints * width; ++e) rows[e] = L(0.0);
    for (int g = 0; g < width; ++g) sweep<kOf>(arm, g, width, rows, at);
  }

  template <unsigned kOf>
  static Seed<L> seed(const Links& tree, int k, int group) {
    const double* q = tree.seeds + long{2} * k * tree.seed_width + group * lanes();
    Seed<L> out{L(0.0), L(0.0)};
    if constexpr (kOf == kOfVelocity) out.ds = lanes_at(q);
    if constexpr ((kOf & kOfPosition) != 0) out.s = lanes_at(q);
    if constexpr (kOf == (kOfPosition | kOfVelocity)) out.ds = lanes_at(q + tree.seed_width);
    return out;
  }

  template <unsigned kOf>
  static void sweep(const InertialLinks& arm, int group, int width, L* rows, const Memory& at) {
    const Links& tree = arm.tree;
    namespace d = recursion_detail;
    int first = tree.count;
    for (int l = group * lanes(); l < (group + 1) * lanes() && l < 2 * tree.joints; ++l) {
      const int moved = tree.first_moved[l % tree.joints];
      if (moved >= 0 && moved < first) first = moved;
    }
    Tangent<L>* t = at.tangent;
    for (int k = 0; k < first; ++k) t[k].force = t[k].moment = d::zero3<L>();
    for (int k = first; k < tree.count; ++k) {
      const Link& link = tree.link[k];
      tangent_step<kOf>(link, arm.inertia[k], at.state[k], seed<kOf>(tree, k, group),
                        link.parent < first ? nullptr : t + link.parent, t[k]);
    }
    for (int k = tree.count - 1; k >= 0; --k) {
      const Link& link = tree.link[k];
      const L& effort = link.type == JointType::kRevolute ? t[k].moment.z : t[k].force.z;
      for (int e = link.first_coefficient; e < link.end_coefficient; ++e) {
        const JointCoefficient& c = tree.coefficient[e];
        using C = typename ConstantOf<S>::type;
        rows[c.coordinate * width + group] += static_cast<C>(c.coefficient) * effort;
      }
      if (link.parent >= 0)
        tangent_back<kOf>(link, at.state[k], seed<kOf>(tree, k, group), t[k], t[link.parent]);
    }
  }

  // ---- regressor ---------------------------------------------------------------------------------

  /// Y, (n x 10 bodies).
  static void regressor(const Links& tree, const S* q, const S* dq, const S* ddq, S* Y,
                        const Memory& at) {
    place(tree, q, dq, ddq, at);
    motion({tree, nullptr}, at);
    const int n = tree.joints;
    for (int group = 0; group < groups(n); ++group) {
      jacobians(tree, group, at);
      const int count = n - group * lanes() < lanes() ? n - group * lanes() : lanes();
      for (int b = 0; b < tree.bodies; ++b) {
        const BodyPlace& place = tree.body[b];
        S* to = Y + 10L * b * n + group * lanes();
        if (place.link < 0) {
          for (int e = 0; e < 10 * count; ++e) to[e / count * n + e % count] = S(0.0);
          continue;
        }
        Column<L> c = at.column[place.link];
        if (!place.is_identity) recursion_detail::transform_motion(place.T_link_body, c.w, c.v);
        // A whole pack may be stored where its surplus lanes fall into columns that are computed
        // later.
        const long left = 10L * (tree.bodies - b) * n;
        regressor_entries(body_motion(at.state[place.link], place), c, [&](int k, const L& y) {
          const bool whole = count == lanes() || (n <= lanes() && left - k * n >= lanes());
          store(y, whole ? lanes() : count, to + k * n);
        });
      }
    }
  }

  /// Computes the Jacobian columns of a group of coordinates, side by side in lanes.
  static void jacobians(const Links& tree, int group, const Memory& at) {
    for (int k = 0; k < tree.count; ++k) {
      const Link& link = tree.link[k];
      Column<L>& c = at.column[k];
      if (link.parent >= 0) {
        c = to_joint(link, at.state[k], at.column[link.parent]);
      } else {
        c.w = c.v = recursion_detail::zero3<L>();
      }
      const L own = lanes_at(tree.seeds + long{2} * k * tree.seed_width + group * lanes());
      (link.type == JointType::kRevolute ? c.w.z : c.v.z) += own;
    }
  }

 private:
  /// Hands out parts of one block of memory; with a null block it only adds up their sizes.
  struct Parts {
    char* memory;
    std::size_t used = 0;

    template <typename T>
    T* take(int count) {
      constexpr std::size_t kAlignment = 64;
      T* const part = memory == nullptr ? nullptr : reinterpret_cast<T*>(memory + used);
      used += (static_cast<std::size_t>(count) * sizeof(T) + kAlignment - 1) / kAlignment *
              kAlignment;
      return part;
    }
  };

  static Memory divide(const Links& tree, Parts& parts) {
    const int n = tree.joints;
    Memory at;
    at.state = parts.template take<LinkState<S>>(tree.count);
    at.tangent = parts.template take<Tangent<L>>(tree.count);
    at.column = parts.template take<Column<L>>(tree.count);
    at.carried = parts.template take<InertiaOf<S>>(tree.count);
    at.momentum = parts.template take<CarriedMomentum<S>>(kWide ? 0 : tree.count);
    at.angle = parts.template take<L>(3 * groups(tree.count));
    at.rows = parts.template take<L>(n * groups(2 * n));
    at.inverse = parts.template take<L>(n * groups(n));
    at.vector = parts.template take<S>(n);
    at.matrix = parts.template take<S>(n * n);
    return at;
  }

  static L lanes_at(const double* from) {
    if constexpr (kWide) {
      L to;
      load_lanes(from, to);
      return to;
    } else {
      return L(static_cast<typename ConstantOf<S>::type>(*from));
    }
  }

  static void store(const L& from, int count, S* to) {
    if constexpr (kWide) store_lanes(from, count, &to->v);
    if constexpr (!kWide) *to = from;
  }

  /// Writes columns first .. end - 1 of a matrix that is given by rows, times a factor.
  static void columns(int n, int width, int first, int end, const S& by, const L* rows, S* to) {
    for (int d = first; d < end; ++d) {
      for (int i = 0; i < n; ++i) {
        const L& from = rows[i * width + d / lanes()];
        S& entry = to[(d - first) * n + i];
        if constexpr (kWide) entry = by * S(from.v[d % lanes()]);
        if constexpr (!kWide) entry = by * from;
      }
    }
  }

  /// True if one coordinate of a group is in the joint variable of link k.
  static bool moves(const Links& tree, int k, int group) {
    const double* own = tree.seeds + long{2} * k * tree.seed_width + group * lanes();
    for (int l = 0; l < lanes(); ++l) {
      if (own[l] != 0.0) return true;
    }
    return false;
  }

  /// Computes the torques that unit accelerations of a group of coordinates need at the joints above
  /// theirs, and half of those at their own; the first group also computes the carried inertias.
  static void mass_columns(const Links& tree, int group, int width, const Memory& at) {
    using C = typename ConstantOf<S>::type;
    namespace d = recursion_detail;
    Tangent<L>* t = at.tangent;
    int last = tree.count - 1;  // the last link with a joint of the group
    while (last > 0 && !moves(tree, last, group)) --last;
    for (int k = 0; k <= last; ++k) t[k].force = t[k].moment = d::zero3<L>();
    for (int k = group == 0 ? tree.count - 1 : last; k >= 0; --k) {
      const Link& link = tree.link[k];
      const InertiaOf<S>& I = at.carried[k];
      if (group == 0 && link.parent >= 0)
        carry_inertia(link, at.state[k], I, at.carried[link.parent]);
      if (k > last) continue;
      const L own = lanes_at(tree.seeds + long{2} * k * tree.seed_width + group * lanes());
      Vec3<L>& force = t[k].force;
      Vec3<L>& moment = t[k].moment;
      L effort;
      if (link.type == JointType::kRevolute) {
        const L needed = (I.xx + I.yy) * own;
        effort = moment.z + static_cast<C>(0.5) * needed;
        force.x -= I.h.y * own;
        force.y += I.h.x * own;
        moment.x -= I.xz * own;
        moment.y -= I.yz * own;
        moment.z += needed;
      } else {
        const L needed = I.m * own;
        effort = force.z + static_cast<C>(0.5) * needed;
        force.z += needed;
        moment.x += I.h.y * own - at.state[k].s * force.y;
        moment.y += at.state[k].s * force.x - I.h.x * own;
      }
      for (int e = link.first_coefficient; e < link.end_coefficient; ++e) {
        const JointCoefficient& c = tree.coefficient[e];
        at.inverse[c.coordinate * width + group] += static_cast<C>(c.coefficient) * effort;
      }
      if (link.parent >= 0)
        d::to_parent(link, at.state[k].R, force, moment, t[link.parent].force, t[link.parent].moment);
    }
  }

  // Computes sines and cosines of all joints in packs, and the rotations.
  static void sines(const Links& tree, const Memory& at) {
    constexpr double kQuickAngle = 1e5;  // [rad]; the fast approximation loses digits beyond it
    const int packs = groups(tree.count);
    for (int k = tree.count; k < packs * lanes(); ++k) at.angle[k / lanes()].v[k % lanes()] = 0.0;
    for (int g = 0; g < packs; ++g)
      sine_cosine(at.angle[g], at.angle[packs + g], at.angle[2 * packs + g]);
    for (int k = 0; k < tree.count; ++k) {
      LinkState<S>& state = at.state[k];
      state.sine = at.angle[packs + k / lanes()].v[k % lanes()];
      state.cosine = at.angle[2 * packs + k / lanes()].v[k % lanes()];
      if (!(__builtin_fabs(state.s.v) < kQuickAngle)) {
        state.sine = __builtin_sin(state.s.v);
        state.cosine = __builtin_cos(state.s.v);
      }
      rotation_step(tree.link[k], state);
    }
  }
};

}  // namespace veridyn
