#pragma once

#include <cstddef>

#include "veridyn/dynamics/recursion.hpp"
#include "veridyn/dynamics/world_recursion.hpp"

namespace veridyn {

/// A tree of moving links with its inertias, see link_inertias().
struct InertialLinks {
  Links tree;
  const LinkInertia* inertia;  ///< null where only motion and regressor are computed
};

/// Rigid-body dynamics at one state over any scalar S. L is a SIMD pack of S whose lanes are neighbouring links
/// or columns, or S itself. Vectors hold n entries; matrices (n x n) are column-major without gaps. All
/// functions work in the caller's memory, see ArmDynamics.
///
/// A joint variable may be a sum of coordinates, s = C q + s0. Derivatives are computed by joint variables;
/// those by coordinates are sums of them, C' D C. The mass matrix is factored along the tree (articulated
/// bodies, O(links)) if every joint has its own coordinate. Otherwise, and for few joints, M itself is
/// factored: a coordinate that moves several joints couples branches of the tree, which the recursion treats
/// as independent.
template <typename S, typename L = S>
struct ArmAlgorithms {
  using World = WorldRecursion<S, L>;
  static constexpr bool kWide = World::kWide;
  static constexpr int lanes() { return World::lanes(); }
  static constexpr int groups(int count) { return World::groups(count); }

  /// Smallest number of links for the recursion along the tree; for fewer, M itself is factored, whose
  /// columns are contiguous. Measured: forward dynamics along the tree takes 1.13 times as long with 7 links,
  /// 0.95 times with 12.
  static constexpr int kArticulatedLinks = 12;

  static bool articulated(const Links& tree) {
    return tree.independent && tree.count >= kArticulatedLinks;
  }

  struct Memory {
    LinkState<S>* state;
    World world;
    Screw<L>* column;   ///< one per link
    Screw<S>* single;   ///< one per link
    typename World::Response* response;  ///< two per link
    InertiaOf<S>* carried;  ///< inertia of each link with all links that it carries
    L* angle;    ///< all angles, then sines, then cosines
    L* rows;     ///< rows of 2 n columns
    L* inverse;  ///< n rows of n columns
    S* pairs;    ///< links x links, each column a whole number of groups
    S* vector;   ///< max(links, joints) entries
    S* matrix;   ///< n x n entries
  };

  /// Size of the workspace in bytes; its memory must be aligned for L.
  static std::size_t workspace(const Links& tree) {
    Parts parts{nullptr};
    divide(tree, parts);
    return parts.used;
  }
  /// Size of the first parts, which are sufficient for regressor().
  static std::size_t regressor_workspace(const Links& tree) {
    Parts parts{nullptr};
    Memory at;
    first_parts(tree, parts, at);
    return parts.used;
  }
  /// The parts of a block of workspace(tree) bytes.
  static Memory divide(const Links& tree, void* memory) {
    Parts parts{static_cast<char*>(memory)};
    return divide(tree, parts);
  }

  // ---- motion and torques ------------------------------------------------------------------------

  /// Computes joint variables, sines, cosines and rotations; a null pointer counts as zeros.
  static void compute_joint_states(const Links& tree, const S* q, const S* dq, const S* ddq, const Memory& at) {
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
    compute_joint_states(arm.tree, q, nullptr, nullptr, at);
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
    compute_joint_states(arm.tree, q, dq, ddq, at);
    motion(arm, at);
    for (int e = 0; e < externals; ++e) {
      LinkState<S>& state = at.state[external[e].link];
      state.force = state.force - constant<S>(external[e].force);
      state.moment = state.moment - constant<S>(external[e].moment);
    }
    backward_pass(arm.tree, {at.state, nullptr}, tau);
  }

  static void mass_matrix(const InertialLinks& arm, const S* q, S* M, const Memory& at) {
    compute_joint_states(arm.tree, q, nullptr, nullptr, at);
    mass_of(arm, M, at);
  }

  /// Computes M from the inertias that the links carry (Featherstone, ch. 6.2); needs compute_joint_states().
  static void mass_of(const InertialLinks& arm, S* M, const Memory& at) {
    at.world.place(arm.tree, at.state);
    at.world.inertias(arm.tree, arm.inertia);
    at.world.sum_over_subtrees(arm.tree, World::kInertia, World::kMomentum);
    mass_pairs(arm.tree, M, at);
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

  /// Computes M and h, where they are not null, and D = scale * dh/d(dq). For scale 1/2, D is the Coriolis
  /// matrix of Christoffel's symbols, for which dM/dt - 2 C is skew.
  static void velocity_derivative(const InertialLinks& arm, const S* q, const S* dq, double scale,
                                  S* M, S* h, S* D, const Memory& at) {
    const Links& tree = arm.tree;
    const World& world = at.world;
    if (h != nullptr) {
      inverse_dynamics(arm, q, dq, nullptr, nullptr, 0, h, at);
    } else {
      compute_joint_states(tree, q, dq, nullptr, at);
    }
    world.place(tree, at.state);
    world.inertias(tree, arm.inertia);
    world.velocities(tree, dq);
    world.sum_over_subtrees(tree, World::kInertia, World::kWrench);
    if (M != nullptr) mass_pairs(tree, M, at);
    if (M == nullptr) world.forces(tree);
    world.changes_by_velocity(tree);
    write_pair_matrix<true>(tree, kVelocityUpper, kVelocityLower, 2.0 * scale, D, at);
  }

  /// Computes dL/dq = C' dq - g of the Lagrangian L = dq' M dq / 2 - U in O(links). With m, h and the momentum
  /// (p, l) of all links that a joint carries, dL/dq = z . (p x v + l x w + h x g) for a revolute joint and z .
  /// (p x w + m g) for a prismatic one, where v and w are the velocities of its link.
  static void lagrangian_gradient(const InertialLinks& arm, const S* q, const S* dq, S* gradient,
                                  const Memory& at) {
    const Links& tree = arm.tree;
    const Vec3d& g = tree.gravity;
    compute_joint_states(tree, q, dq, nullptr, at);
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
      InertiaOf<S>& I = at.carried[k];  // only m and h of this sum are updated
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
    const Links& tree = arm.tree;
    compute_joint_states(tree, q, dq, ddq, at);
    at.world.place(tree, at.state);
    compute_derivative_terms(arm, dq, ddq, at);
    for (int i = 0; i < tree.joints; ++i) tau[i] = S(0.0);
    for (int k = 0; k < tree.count; ++k) {
      const S effort = at.world.torque(k);
      for_coefficients(tree, k, [&](int i, double of_i) {
        tau[i] += static_cast<typename ConstantOf<S>::type>(of_i) * effort;
      });
    }
    mass_pairs(tree, M, at);
    write_pair_matrix<true>(tree, kPositionUpper, kPositionLower, 2.0, by_q, at);
    write_pair_matrix<true>(tree, kVelocityUpper, kVelocityLower, 2.0, by_dq, at);
  }

  // ---- forward dynamics --------------------------------------------------------------------------

  /// Solves for ddq of tau; leaves M factored, in `M` or along the tree. False if M is not positive definite.
  static bool forward_dynamics(const InertialLinks& arm, const S* q, const S* dq, const S* tau,
                               S* ddq, S* M, const Memory& at) {
    const Links& tree = arm.tree;
    const int n = tree.joints;
    inverse_dynamics(arm, q, dq, nullptr, nullptr, 0, ddq, at);
    for (int i = 0; i < n; ++i) ddq[i] = tau[i] - ddq[i];
    if (!articulated(tree)) {
      mass_of(arm, M, at);
      if (!factor(n, M)) return false;
      solve(n, M, 1, ddq);
      return true;
    }
    at.world.place(tree, at.state);
    at.world.inertias(tree, arm.inertia);
    if (!at.world.articulate(tree)) return false;
    for (int k = 0; k < n; ++k) at.vector[k] = ddq[coordinate(tree, k)];
    at.world.solve(tree, at.vector, at.single);
    for (int k = 0; k < n; ++k) ddq[coordinate(tree, k)] = at.vector[k];
    return true;
  }

  /// Computes ddq and its derivatives by q, dq and tau: -M^-1 dtau/dx at that ddq, and M^-1. False as forward_dynamics().
  static bool forward_derivatives(const InertialLinks& arm, const S* q, const S* dq, const S* tau,
                                  S* ddq, S* by_q, S* by_dq, S* by_tau, const Memory& at) {
    const Links& tree = arm.tree;
    const int n = tree.joints;
    if (!forward_dynamics(arm, q, dq, tau, ddq, at.matrix, at)) return false;
    const int wide = 2 * groups(n);
    const int narrow = groups(n);
    if (articulated(tree)) {
      at.world.velocities(tree, dq);
      at.world.accelerations(tree, dq, ddq);
      at.world.sum_over_subtrees(tree, World::kWrench, World::kAxis);
      at.world.articulated_changes(tree);
      for (int g = 0; g < narrow; ++g) {
        at.world.respond_to_motion(tree, g, wide, at.rows + g, at.response);
        at.world.respond_to_torque(tree, g, narrow, at.inverse + g, at.response);
      }
      S* const inverse = reinterpret_cast<S*>(at.inverse);
      const int ld = narrow * lanes();
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < i; ++j) inverse[i * ld + j] = inverse[j * ld + i];
      }
    } else {
      if (!tree.independent) {  // the joint variables' own accelerations
        for (int k = 0; k < tree.count; ++k)
          at.state[k].dds = along_joint(arm.tree, arm.tree.link[k], ddq);
      }
      compute_derivative_terms(arm, dq, ddq, at);
      write_pair_matrix_rows(tree, kPositionUpper, kPositionLower, 0, at);
      write_pair_matrix_rows(tree, kVelocityUpper, kVelocityLower, narrow, at);
      for (int e = 0; e < n * narrow; ++e) at.inverse[e] = L(0.0);
      for (int i = 0; i < n; ++i) {
        L& unit = at.inverse[i * narrow + i / lanes()];
        if constexpr (kWide) unit.v[i % lanes()] = 1.0;
        if constexpr (!kWide) unit = S(1.0);
      }
      solve(n, at.matrix, wide, at.rows);
      solve(n, at.matrix, narrow, at.inverse);
    }
    write_by_columns(tree, wide, 0, -2.0, at.rows, by_q, at);
    write_by_columns(tree, wide, narrow, -2.0, at.rows, by_dq, at);
    write_by_columns(tree, narrow, 0, 1.0, at.inverse, by_tau, at);
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

  // ---- regressor ---------------------------------------------------------------------------------

  /// Y, (n x 10 bodies).
  static void regressor(const Links& tree, const S* q, const S* dq, const S* ddq, S* Y,
                        const Memory& at) {
    compute_joint_states(tree, q, dq, ddq, at);
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
        // A whole pack may be stored where its surplus lanes fall into columns that are computed later.
        const long left = 10L * (tree.bodies - b) * n;
        regressor_entries(body_motion(at.state[place.link], place), c, [&](int k, const L& y) {
          const bool whole = count == lanes() || (n <= lanes() && left - k * n >= lanes());
          World::store(y, whole ? lanes() : count, to + k * n);
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
      const L own = lanes_at(tree.seeds + long{k} * tree.seed_width + group * lanes());
      (link.type == JointType::kRevolute ? c.w.z : c.v.z) += own;
    }
  }

 private:
  /// Assigns parts of one block of memory; with a null block it only adds up their sizes.
  struct Parts {
    char* memory;
    std::size_t used = 0;

    template <typename T>
    T* allocate(int count) {
      constexpr std::size_t kAlignment = kWide ? 64 : sizeof(S);
      T* const part = memory == nullptr ? nullptr : reinterpret_cast<T*>(memory + used);
      used += (static_cast<std::size_t>(count) * sizeof(T) + kAlignment - 1) / kAlignment *
              kAlignment;
      return part;
    }
  };

  /// Sets state, column and angle of `at`; the other pointers stay as they are.
  static void first_parts(const Links& tree, Parts& parts, Memory& at) {
    at.state = parts.template allocate<LinkState<S>>(tree.count);
    at.column = parts.template allocate<Screw<L>>(tree.count);
    at.angle = parts.template allocate<L>(3 * groups(tree.count));
  }

  static Memory divide(const Links& tree, Parts& parts) {
    const int n = tree.joints;
    const int most = n > tree.count ? n : tree.count;
    const int padded = groups(tree.count) * lanes();
    Memory at;
    first_parts(tree, parts, at);
    at.world.stride = padded;
    at.world.data = parts.template allocate<S>(World::kArrays * padded);
    at.world.pose = parts.template allocate<Pose<S>>(tree.count);
    at.world.articulated = parts.template allocate<ArticulatedInertia<S>>(tree.count);
    at.world.joint = parts.template allocate<ArticulatedJoint<S>>(tree.count);
    at.response = parts.template allocate<typename World::Response>(2 * tree.count);
    at.single = parts.template allocate<Screw<S>>(tree.count);
    at.carried = parts.template allocate<InertiaOf<S>>(tree.count);
    at.rows = parts.template allocate<L>(n * 2 * groups(n));
    at.inverse = parts.template allocate<L>(n * groups(n));
    at.pairs = parts.template allocate<S>(tree.count * padded);
    at.vector = parts.template allocate<S>(most);
    at.matrix = parts.template allocate<S>(n * n);
    return at;
  }

  /// A pack of the numbers from `from` on, or that number alone.
  static L lanes_at(const double* from) {
    if constexpr (kWide) {
      L to;
      load_lanes(from, to);
      return to;
    } else {
      return L(static_cast<typename ConstantOf<S>::type>(*from));
    }
  }

  static constexpr typename World::Products kMassUpper{World::kAxis, World::kForce};
  static constexpr typename World::Products kMassLower{World::kForce, World::kAxis};
  // Pairs of quantities whose products are the two triangles of each derivative, see WorldRecursion::Quantity.
  static constexpr typename World::Products kPositionUpper{World::kAxis, World::kByPosition};
  static constexpr typename World::Products kPositionLower{World::kForce, World::kTurn,
                                                           World::kSpin, World::kDrift};
  static constexpr typename World::Products kVelocityUpper{World::kAxis, World::kByVelocity};
  static constexpr typename World::Products kVelocityLower{World::kForce, World::kDrift,
                                                           World::kSpin, World::kAxis};

  /// Computes the quantities from which all derivatives of the torques follow; needs World::place().
  static void compute_derivative_terms(const InertialLinks& arm, const S* dq, const S* ddq, const Memory& at) {
    const Links& tree = arm.tree;
    at.world.inertias(tree, arm.inertia);
    at.world.velocities(tree, dq);
    at.world.accelerations(tree, dq, ddq);
    at.world.sum_over_subtrees(tree, World::kInertia, World::kAxis);
    at.world.forces(tree);
    at.world.changes_by_velocity(tree);
    at.world.changes_by_position(tree);
  }

  /// Computes M, exactly symmetric, from inertias that are summed over subtrees.
  static void mass_pairs(const Links& tree, S* M, const Memory& at) {
    at.world.forces(tree);
    write_pair_matrix<false>(tree, kMassUpper, kMassLower, 1.0, M, at);
    if (tree.in_order) return;  // else the triangles are summed in different orders, and M is not exactly symmetric
    const int n = tree.joints;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < i; ++j) M[j * n + i] = M[i * n + j];
    }
  }

  /// Computes an (n x n) matrix over coordinates, which is `scale` times a sum over pairs of links; with kVectors, also of their vectors.
  template <bool kVectors>
  static void write_pair_matrix(const Links& tree, const typename World::Products& upper,
                                const typename World::Products& lower, double scale, S* to,
                                const Memory& at) {
    const S by(static_cast<typename ConstantOf<S>::type>(scale));
    write_pair_sums<false, kVectors>(tree, upper, lower, by, to, tree.joints, at);
  }

  /// Computes such a matrix by rows of 2 groups(n), beginning at group `first`.
  static void write_pair_matrix_rows(const Links& tree, const typename World::Products& upper,
                                     const typename World::Products& lower, int first, const Memory& at) {
    const int groups_of_row = 2 * groups(tree.joints);
    S* const to = reinterpret_cast<S*>(at.rows + first);
    write_pair_sums<true, true>(tree, upper, lower, S(1.0), to, groups_of_row * lanes(), at);
  }

  template <bool kTransposed, bool kVectors>
  static void write_pair_sums(const Links& tree, const typename World::Products& upper,
                              const typename World::Products& lower, const S& scale, S* to, int ld,
                              const Memory& at) {
    if (tree.in_order)
      return at.world.template write_pair_products<kTransposed, kVectors>(tree, upper, lower, scale, to, ld);
    at.world.template write_pair_products<kTransposed, kVectors>(tree, upper, lower, scale, at.pairs,
                                                                 at.world.stride);
    for (int j = 0; j < tree.joints; ++j) {
      for (int i = 0; i < tree.joints; ++i) to[long{j} * ld + i] = S(0.0);
    }
    for (int l = 0; l < tree.count; ++l) {
      for (int k = 0; k < tree.count; ++k) {
        const S& entry = at.pairs[long{l} * at.world.stride + k];
        for_coefficients(tree, l, [&](int j, double of_j) {
          for_coefficients(tree, k, [&](int i, double of_i) {
            to[long{j} * ld + i] += static_cast<typename ConstantOf<S>::type>(of_j * of_i) * entry;
          });
        });
      }
    }
  }

  /// Calls body(coordinate, coefficient) for each coordinate of link k's joint variable.
  template <typename Body>
  static void for_coefficients(const Links& tree, int k, const Body& body) {
    const Link& link = tree.link[k];
    for (int e = link.first_coefficient; e < link.end_coefficient; ++e)
      body(tree.coefficient[e].coordinate,
           tree.independent ? 1.0 : tree.coefficient[e].coefficient);
  }

  /// The coordinate of link k; its first one if it has several.
  static int coordinate(const Links& tree, int k) {
    return tree.coefficient[tree.link[k].first_coefficient].coordinate;
  }

  /// Writes n columns, times `by`, of a matrix whose rows have `width` packs, of which those from `first` on are read.
  static void write_by_columns(const Links& tree, int width, int first, double by, L* rows, S* to,
                               const Memory& at) {
    const int n = tree.joints;
    const S factor(static_cast<typename ConstantOf<S>::type>(by));
    const S* const from = reinterpret_cast<const S*>(rows + first);
    const int ld = width * lanes();
    const bool by_links = articulated(tree) && !tree.in_order;
    S* const direct = by_links ? at.matrix : to;
    int i = 0;
    for (; i + 4 <= n; i += 4) {
      const S* row = from + long{i} * ld;
      S* column = direct + i;
      for (int d = 0; d < n; ++d, ++row, column += n) {
        column[0] = factor * row[0];
        column[1] = factor * row[ld];
        column[2] = factor * row[2 * ld];
        column[3] = factor * row[3 * ld];
      }
    }
    for (; i < n; ++i) {
      for (int d = 0; d < n; ++d) direct[long{d} * n + i] = factor * from[long{i} * ld + d];
    }
    if (!by_links) return;
    for (int d = 0; d < n; ++d) {
      S* const column = to + long{n} * coordinate(tree, d);
      for (int k = 0; k < n; ++k) column[coordinate(tree, k)] = direct[long{d} * n + k];
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
