#pragma once

#include "arm_kernels.hpp"
#include "math/dual.hpp"
#include "math/pack.hpp"

// Each arm_kernels_<isa>.cpp is compiled with flags of its own, so nothing here may be shared with
// the rest of the program: the linker keeps one copy of an inline function, and an older processor
// could then execute instructions that it lacks. Hence raw pointers, no Eigen, and templates over
// packs whose tag names the instruction set, single numbers included.

namespace veridyn {

template <int kLanes, typename Isa>
struct ArmKernelLoops {
  using One = Pack<1, Isa>;
  using P = Pack<kLanes, Isa>;
  using D = Dual<P>;
  using State = ArmAlgorithms<One, P>;
  using Batch = ArmAlgorithms<P>;

  // Arguments of a kernel in the types of the algorithms.
  static const One* lane(const Links&, const double* x) { return reinterpret_cast<const One*>(x); }
  static One* lane(const Links&, double* x) { return reinterpret_cast<One*>(x); }
  static typename State::Memory lane(const Links& tree, void* memory) { return State::divide(tree, memory); }
  template <typename Other>
  static Other lane(const Links&, Other other) { return other; }

  static const Links& tree_of(const Links& tree) { return tree; }
  static const Links& tree_of(const InertialLinks& arm) { return arm.tree; }

  // Each algorithm is flattened into one function, as the batches below: otherwise the compiler keeps calls in
  // the innermost loops, and the code is slower by a third.
  template <auto kAlgorithm, typename Result, typename Arm, typename... In>
  __attribute__((flatten)) static Result run(const Arm& arm, In... in) {
    return kAlgorithm(arm, lane(tree_of(arm), in)...);
  }
  template <auto kAlgorithm, typename Result, typename Arm, typename... In>
  static void set(Result (*&kernel)(const Arm&, In...)) {
    kernel = &run<kAlgorithm, Result, Arm, In...>;
  }

  // ---- batches -----------------------------------------------------------------------------------

  struct BatchMemory {
    typename Batch::Memory at;
    D* duals;  ///< a complete workspace of dual numbers, in the same memory
    P* q;
    P* dq;
    P* ddq;
    P* tau;
    Column<P>* jacobian;
  };

  // Size [bytes] of the workspace of for_entries() with dual numbers.
  static std::size_t dual_bytes(const Links& tree) {
    return sizeof(LinkState<D>) * static_cast<std::size_t>(tree.count) +
           sizeof(Column<D>) * static_cast<std::size_t>(tree.supports);
  }
  static std::size_t padded(std::size_t bytes) { return (bytes + 63) / 64 * 64; }
  static std::size_t batch_workspace(const Links& tree) {
    const std::size_t plain = Batch::workspace(tree);
    const std::size_t dual = dual_bytes(tree);
    return padded(plain > dual ? plain : dual) +
           sizeof(D) * 4 * static_cast<std::size_t>(tree.joints) +
           sizeof(Column<P>) * static_cast<std::size_t>(tree.supports);
  }
  // The parts of a block of batch_workspace(tree) bytes.
  static BatchMemory divide(const Links& tree, void* memory) {
    const std::size_t plain = Batch::workspace(tree);
    const std::size_t dual = dual_bytes(tree);
    char* const rest = static_cast<char*>(memory) + padded(plain > dual ? plain : dual);
    P* const q = reinterpret_cast<P*>(rest);
    Column<P>* const jacobian =
        reinterpret_cast<Column<P>*>(rest + sizeof(D) * 4 * static_cast<std::size_t>(tree.joints));
    const int n = tree.joints;
    return {Batch::divide(tree, memory), static_cast<D*>(memory), q, q + n, q + 2 * n, q + 3 * n,
            jacobian};
  }

  // Packs `count` samples from `row` on, one pack for each joint; further lanes repeat the last sample.
  static void load(const Links& tree, const SampleColumns& from, int row, int count, P* to) {
    for (int i = 0; i < tree.joints; ++i)
      to[i] = load_lanes<P>(count, from.data + i * from.stride + row);
  }
  static void load(const Links& tree, const BatchInput& in, int row, int count,
                   const BatchMemory& m) {
    load(tree, in.q, row, count, m.q);
    load(tree, in.dq, row, count, m.dq);
    load(tree, in.ddq, row, count, m.ddq);
  }

  // Calls body(row, count) for every pack of rows.
  template <typename Body>
  static void for_packs(int rows, const Body& body) {
    int row = 0;
    for (; row + kLanes <= rows; row += kLanes) body(row, kLanes);
    if (row < rows) body(row, rows - row);
  }

  __attribute__((flatten)) static void batch_regressor(const Links& tree, const BatchInput& in,
                                                       const ColumnsByJoint<double>& out,
                                                       void* memory) {
    const BatchMemory m = divide(tree, memory);
    const Workspace<P> r{m.at.state, m.jacobian};
    const long rows = in.rows;
    for_packs(in.rows, [&](int row, int count) {
      load(tree, in, row, count, m);
      for_entries(tree, m.q, r, [&](int b, int i, const BodyMotion<P>& motion, const Column<P>& c) {
        double* const Y = out.Y[i];
        if (Y == nullptr) return;
        double* const column = Y + out.first_column[b * tree.joints + i] * rows + row;
        regressor_entries(motion, c,
                          [&](int k, const P& y) { store_lanes(y, count, column + k * rows); });
      });
    });
  }

  // Calls body(b, i, motion, column) for every body and each coordinate that moves it, link by
  // link, so that the data of a link are still in the cache. x holds q, dq and ddq.
  template <typename S, typename Body>
  static void for_entries(const Links& tree, const S* x, const Workspace<S>& r, const Body& body) {
    joint_pass(tree, x, x + tree.joints, x + 2 * tree.joints, r);
    for (int k = 0; k < tree.count; ++k) {
      const Link& link = tree.link[k];
      forward_step(tree, k, tree.gravity, r);
      jacobian_step(tree, k, r);
      for (int b = link.body; b >= 0; b = tree.body[b].next) {
        const BodyPlace& place = tree.body[b];
        const BodyMotion<S> motion = body_motion(r.link[k], place);
        for (int m = link.first_support; m < link.end_support; ++m) {
          Column<S> c = r.jacobian[m];
          if (!place.is_identity) recursion_detail::transform_motion(place.T_link_body, c.w, c.v);
          body(b, tree.support[m].coordinate, motion, c);
        }
      }
    }
  }

  __attribute__((flatten)) static void batch_torques(const InertialLinks& arm,
                                                     const BatchInput& in, double* tau,
                                                     void* memory) {
    const BatchMemory m = divide(arm.tree, memory);
    for_packs(in.rows, [&](int row, int count) {
      load(arm.tree, in, row, count, m);
      Batch::inverse_dynamics(arm, m.q, m.dq, m.ddq, nullptr, 0, m.tau, m.at);
      for (int i = 0; i < arm.tree.joints; ++i)
        store_lanes(m.tau[i], count, tau + long{i} * in.rows + row);
    });
  }

  __attribute__((flatten)) static void batch_derivatives(const InertialLinks& arm,
                                                         const BatchInput& in, double* out,
                                                         void* memory) {
    const BatchMemory m = divide(arm.tree, memory);
    const int n = arm.tree.joints;
    for_packs(in.rows, [&](int row, int count) {
      load(arm.tree, in, row, count, m);
      P* const by_q = m.at.rows;
      P* const by_dq = m.at.rows + n * n;
      Batch::derivatives(arm, m.q, m.dq, m.ddq, m.tau, by_q, by_dq, m.at.matrix, m.at);
      for (int e = 0; e < n * n; ++e) {
        const P* const by[] = {by_q, by_dq, m.at.matrix};
        for (int kind = 0; kind < 3; ++kind)
          store_lanes(by[kind][e], count, out + (long{kind} * n * n + e) * in.rows + row);
      }
    });
  }

  // Computes the gradient by the same recursions over dual numbers of packs, one direction at a time.
  __attribute__((flatten)) static void batch_gradient(const Links& tree, const BatchInput& in,
                                                      const ColumnsByJoint<const double>& weights,
                                                      double* out, void* memory) {
    const BatchMemory m = divide(tree, memory);
    LinkState<D>* const link = reinterpret_cast<LinkState<D>*>(m.duals);
    const Workspace<D> r{link, reinterpret_cast<Column<D>*>(link + tree.count)};
    D* const x = reinterpret_cast<D*>(m.q);
    const int n = tree.joints;
    const SampleColumns* const parts[] = {&in.q, &in.dq, &in.ddq};
    for_packs(in.rows, [&](int row, int count) {
      for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < n; ++i)
          x[k * n + i] = {load_lanes<P>(count, parts[k]->data + i * parts[k]->stride + row), P(0.0)};
      }
      for (int d = 0; d < 3 * n; ++d) {
        x[d].derivative = P(1.0);
        P sum(0.0);
        for_entries(tree, x, r, [&](int b, int i, const BodyMotion<D>& motion, const Column<D>& c) {
          const double* const w =
              weights.Y[i] + long{weights.first_column[b * n + i]} * in.rows + row;
          regressor_entries(motion, c, [&](int k, const D& y) {
            sum += load_lanes<P>(count, w + long{k} * in.rows) * y.derivative;
          });
        });
        x[d].derivative = P(0.0);
        store_lanes(sum, count, out + long{d} * in.rows + row);
      }
    });
  }

  static ArmKernels kernels() {
    ArmKernels out;
    out.workspace = &State::workspace;
    out.regressor_workspace = &State::regressor_workspace;
    set<&State::inverse_dynamics>(out.inverse_dynamics);
    set<&State::gravity_torques>(out.gravity_torques);
    set<&State::mass_matrix>(out.mass_matrix);
    set<&State::equation_of_motion>(out.equation_of_motion);
    set<&State::velocity_derivative>(out.velocity_derivative);
    set<&State::lagrangian_gradient>(out.lagrangian_gradient);
    set<&State::derivatives>(out.derivatives);
    set<&State::forward_dynamics>(out.forward_dynamics);
    set<&State::forward_derivatives>(out.forward_derivatives);
    set<&State::regressor>(out.regressor);
    out.lanes = kLanes;
    out.batch_workspace = &batch_workspace;
    out.batch_regressor = &batch_regressor;
    out.batch_torques = &batch_torques;
    out.batch_derivatives = &batch_derivatives;
    out.batch_gradient = &batch_gradient;
    return out;
  }
};

}  // namespace veridyn
