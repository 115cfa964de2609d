#pragma once

#include "regressor_batch_kernels.hpp"
#include "math/dual.hpp"

// Derivatives of the batch along q, dq and ddq: the same recursions over dual numbers of packs, one
// direction at a time. The rules of regressor_batch_kernels.hpp hold here too.

namespace veridyn {

/// Weights of the regressor's entries: those of column c of joint i stand at W[i] + c * rows.
struct RegressorWeights {
  const double* const* W;
  const int* column_of_mover;
};

template <typename P>
struct GradientLoops {
  using D = Dual<P>;
  using Plain = BatchLoops<P>;
  using Unaligned = typename Plain::Unaligned;
  using Rows = typename Plain::Rows;

  struct Memory {
    Workspace<D> passes;
    D* state;  ///< q, dq, ddq: 3 n
    D* tau;
  };

  static unsigned long workspace(const Links& tree) {
    return sizeof(LinkState<D>) * tree.count + sizeof(Column<D>) * tree.movers +
           sizeof(D) * 4 * tree.joints;
  }

  static Memory divide(const Links& tree, void* memory) {
    LinkState<D>* link = static_cast<LinkState<D>*>(memory);
    Column<D>* jacobian = reinterpret_cast<Column<D>*>(link + tree.count);
    D* state = reinterpret_cast<D*>(jacobian + tree.movers);
    return {{link, jacobian, nullptr}, state, state + 3 * tree.joints};
  }

  static P load_one(const double* from, int count) {
    P out(0.0);
    if (count == P::kSize) {
      out.v = *reinterpret_cast<const Unaligned*>(from);
    } else {
      for (int l = 0; l < P::kSize; ++l) out.v[l] = from[l < count ? l : count - 1];
    }
    return out;
  }

  static void store_one(const P& from, int count, double* to) {
    if (count == P::kSize) {
      *reinterpret_cast<Unaligned*>(to) = from.v;
    } else {
      for (int l = 0; l < count; ++l) to[l] = from.v[l];
    }
  }

  static void load_state(const Links& tree, const BatchInput& in, int row, int count,
                         const Memory& at) {
    const SampleColumns* parts[] = {&in.q, &in.dq, &in.ddq};
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < tree.joints; ++i) {
        D& x = at.state[k * tree.joints + i];
        x.value = load_one(parts[k]->data + i * parts[k]->stride + row, count);
        x.derivative = P(0.0);
      }
    }
  }

  static void motion(const Links& tree, const Memory& at) {
    const int n = tree.joints;
    forward_pass(tree, at.state, at.state + n, at.state + 2 * n, tree.gravity, at.passes);
  }

  // The derivative of sum_ic W_ic Y_ic along the direction that is seeded.
  static P weighted_slope(const Links& tree, int rows, int row, int count,
                          const RegressorWeights& weights, const Memory& at) {
    motion(tree, at);
    jacobian_pass(tree, at.passes);
    P sum(0.0);
    for (int k = 0; k < tree.count; ++k) {
      if (tree.link[k].body < 0) continue;
      const BodyMotion<D> body = body_motion(at.passes.link[k]);
      for (int m = tree.link[k].first_mover; m < tree.link[k].end_mover; ++m) {
        const double* w =
            weights.W[tree.mover[m].coordinate] + long{weights.column_of_mover[m]} * rows + row;
        regressor_entries(body, at.passes.jacobian[m], [&](int c, const D& y) {
          sum += load_one(w + long{c} * rows, count) * y.derivative;
        });
      }
    }
    return sum;
  }

  /// out: (rows x 3 n), column-major.
  __attribute__((flatten)) static void gradient(const Links& tree, const BatchInput& in,
                                                const RegressorWeights& weights, double* out,
                                                void* workspace) {
    const Memory at = divide(tree, workspace);
    for (int row = 0; row < in.rows; row += P::kSize) {
      const int count = in.rows - row < P::kSize ? in.rows - row : P::kSize;
      load_state(tree, in, row, count, at);
      for (int d = 0; d < 3 * tree.joints; ++d) {
        at.state[d].derivative = P(1.0);
        const P sum = weighted_slope(tree, in.rows, row, count, weights, at);
        at.state[d].derivative = P(0.0);
        store_one(sum, count, out + long{d} * in.rows + row);
      }
    }
  }

  /// tau: (rows x n); slopes: 3 n matrices (rows x n), one after the other.
  __attribute__((flatten)) static void torque_slopes(const Links& tree, const BatchInput& in,
                                                     const double* phi, double* slopes,
                                                     void* workspace) {
    const Memory at = divide(tree, workspace);
    const int n = tree.joints;
    for (int row = 0; row < in.rows; row += P::kSize) {
      const int count = in.rows - row < P::kSize ? in.rows - row : P::kSize;
      load_state(tree, in, row, count, at);
      for (int d = 0; d < 3 * n; ++d) {
        at.state[d].derivative = P(1.0);
        motion(tree, at);
        backward_pass(tree, phi, at.passes, at.tau);
        at.state[d].derivative = P(0.0);
        for (int i = 0; i < n; ++i)
          store_one(at.tau[i].derivative, count, slopes + (long{d} * n + i) * in.rows + row);
      }
    }
  }

  /// The plain kernels with these beside them.
  static BatchKernels kernels() {
    BatchKernels all = Plain::kernels();
    all.gradient_workspace = &workspace;
    all.gradient = &gradient;
    all.torque_slopes = &torque_slopes;
    return all;
  }
};

}  // namespace veridyn
