#pragma once

#include "veridyn/dynamics/recursion.hpp"
#include "math/pack.hpp"

// The inner loops of RegressorBatch, once per instruction set. Each regressor_batch_<isa>.cpp is
// compiled with flags of its own, so nothing in here may be shared with the rest of the program:
// the linker keeps one copy of an inline function, and an old processor would run into the new one.
// Hence raw pointers, no standard library, no Eigen, and templates over a pack whose tag names the
// instruction set.

namespace veridyn {

/// Column-major samples; `stride` is the distance between columns.
struct SampleColumns {
  const double* data;
  long stride;
};

struct BatchInput {
  int rows;
  SampleColumns q, dq, ddq;
};

/// Where the regressor goes: column c of joint i stands at Y[i] + c * rows; null: nobody wants it.
struct RegressorOutput {
  double* const* Y;
  const int* column_of_mover;  ///< first of a body's ten columns in its joint's matrix; -1: the
                               ///< link has no body
};

struct RegressorWeights;

/// Null where the compiler was not allowed to use the instruction set.
struct BatchKernels {
  /// Bytes of workspace, aligned to 64.
  unsigned long (*workspace)(const Links& tree) = nullptr;
  void (*regressor)(const Links& tree, const BatchInput& in, const RegressorOutput& out,
                    void* workspace) = nullptr;
  /// phi: ten per body; tau: (rows x n), column-major without gaps.
  void (*torques)(const Links& tree, const BatchInput& in, const double* phi, double* tau,
                  void* workspace) = nullptr;
  // Derivatives, see motion_gradient_kernels.hpp.
  unsigned long (*gradient_workspace)(const Links& tree) = nullptr;
  void (*gradient)(const Links& tree, const BatchInput& in, const RegressorWeights& weights,
                   double* out, void* workspace) = nullptr;
  void (*torque_slopes)(const Links& tree, const BatchInput& in, const double* phi, double* slopes,
                        void* workspace) = nullptr;
  int lanes = 0;  ///< samples that are worked on at once
};

BatchKernels batch_kernels_baseline();
BatchKernels batch_kernels_avx2();
BatchKernels batch_kernels_avx512();

/// The widest that this processor has.
const BatchKernels& widest_batch_kernels();

template <typename P>
struct BatchLoops {
  struct Memory {
    Workspace<P> passes;
    P* q;
    P* dq;
    P* ddq;
    P* tau;
  };

  static unsigned long workspace(const Links& tree) {
    return sizeof(LinkState<P>) * tree.count + sizeof(Column<P>) * tree.movers +
           sizeof(P) * 4 * tree.joints;
  }

  static Memory divide(const Links& tree, void* memory) {
    LinkState<P>* link = static_cast<LinkState<P>*>(memory);
    Column<P>* jacobian = reinterpret_cast<Column<P>*>(link + tree.count);
    P* q = reinterpret_cast<P*>(jacobian + tree.movers);
    return {
        {link, jacobian, nullptr}, q, q + tree.joints, q + 2 * tree.joints, q + 3 * tree.joints};
  }

  /// A pack in memory that is aligned for doubles only.
  typedef double Unaligned __attribute__((vector_size(sizeof(P)), aligned(8), may_alias));

  enum class Rows { kAll, kSome };

  /// The lanes past the last row repeat it.
  template <Rows kRows>
  static void load(const Links& tree, const SampleColumns& from, int row, int count, P* to) {
    for (int i = 0; i < tree.joints; ++i) {
      const double* column = from.data + i * from.stride + row;
      if (kRows == Rows::kAll) {
        to[i].v = *reinterpret_cast<const Unaligned*>(column);
      } else {
        for (int l = 0; l < P::kSize; ++l) to[i].v[l] = column[l < count ? l : count - 1];
      }
    }
  }

  template <Rows kRows>
  static void store(const P& from, int count, double* to) {
    if (kRows == Rows::kAll) {
      *reinterpret_cast<Unaligned*>(to) = from.v;
    } else {
      for (int l = 0; l < count; ++l) to[l] = from.v[l];
    }
  }

  template <Rows kRows>
  static void motion(const Links& tree, const BatchInput& in, int row, int count,
                     const Memory& at) {
    load<kRows>(tree, in.q, row, count, at.q);
    load<kRows>(tree, in.dq, row, count, at.dq);
    load<kRows>(tree, in.ddq, row, count, at.ddq);
    forward_pass(tree, at.q, at.dq, at.ddq, tree.gravity, at.passes);
  }

  template <Rows kRows>
  static void regressor_of(const Links& tree, const BatchInput& in, int row, int count,
                           const RegressorOutput& out, const Memory& at) {
    motion<kRows>(tree, in, row, count, at);
    jacobian_pass(tree, at.passes);
    const long rows = in.rows;
    for (int k = 0; k < tree.count; ++k) {
      if (tree.link[k].body < 0) continue;
      const BodyMotion<P> body = body_motion(at.passes.link[k]);
      for (int m = tree.link[k].first_mover; m < tree.link[k].end_mover; ++m) {
        double* matrix = out.Y[tree.mover[m].coordinate];
        if (matrix == nullptr) continue;
        double* column = matrix + out.column_of_mover[m] * rows + row;
        regressor_entries(body, at.passes.jacobian[m],
                          [&](int c, const P& y) { store<kRows>(y, count, column + c * rows); });
      }
    }
  }

  template <Rows kRows>
  static void torques_of(const Links& tree, const BatchInput& in, int row, int count,
                         const double* phi, double* tau, const Memory& at) {
    motion<kRows>(tree, in, row, count, at);
    backward_pass(tree, phi, at.passes, at.tau);
    for (int i = 0; i < tree.joints; ++i)
      store<kRows>(at.tau[i], count, tau + long{i} * in.rows + row);
  }

  // Everything in one function each: the compiler's own choice leaves calls in the innermost loops
  // (a third slower).
  __attribute__((flatten)) static void regressor(const Links& tree, const BatchInput& in,
                                                 const RegressorOutput& out, void* workspace) {
    const Memory at = divide(tree, workspace);
    int row = 0;
    for (; row + P::kSize <= in.rows; row += P::kSize)
      regressor_of<Rows::kAll>(tree, in, row, P::kSize, out, at);
    if (row < in.rows) regressor_of<Rows::kSome>(tree, in, row, in.rows - row, out, at);
  }

  __attribute__((flatten)) static void torques(const Links& tree, const BatchInput& in,
                                               const double* phi, double* tau, void* workspace) {
    const Memory at = divide(tree, workspace);
    int row = 0;
    for (; row + P::kSize <= in.rows; row += P::kSize)
      torques_of<Rows::kAll>(tree, in, row, P::kSize, phi, tau, at);
    if (row < in.rows) torques_of<Rows::kSome>(tree, in, row, in.rows - row, phi, tau, at);
  }

  static BatchKernels kernels() {
    BatchKernels out;
    out.workspace = &workspace;
    out.regressor = &regressor;
    out.torques = &torques;
    out.lanes = P::kSize;
    return out;
  }
};

}  // namespace veridyn
