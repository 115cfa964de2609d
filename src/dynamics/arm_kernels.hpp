#pragma once

#include "veridyn/dynamics/arm_algorithms.hpp"

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

/// The regressor by joints: column c of joint i begins at Y[i] + c * rows; null: not computed.
template <typename Number>
struct ColumnsByJoint {
  Number* const* Y;
  /// Index of body b's first column in joint i's matrix at b * n + i; -1: the joint does not move the body.
  const int* first_column;
};

/// The algorithms of arm_algorithms.hpp for doubles, compiled for one instruction set. Vectors hold
/// n entries, matrices are column-major without gaps; workspaces are aligned to 64 bytes. All
/// pointers are null if the build does not include the instruction set.
struct ArmKernels {
  // Single states: scalars along the tree, columns of matrices in lanes.
  std::size_t (*workspace)(const Links&) = nullptr;
  std::size_t (*regressor_workspace)(const Links&) = nullptr;
  void (*inverse_dynamics)(const InertialLinks&, const double* q, const double* dq,
                           const double* ddq, const LinkWrench* external, int externals,
                           double* tau, void* workspace) = nullptr;
  void (*gravity_torques)(const InertialLinks&, const double* q, double* g,
                          void* workspace) = nullptr;
  void (*mass_matrix)(const InertialLinks&, const double* q, double* M, void* workspace) = nullptr;
  void (*equation_of_motion)(const InertialLinks&, const double* q, const double* dq, double* M,
                             double* h, void* workspace) = nullptr;
  void (*velocity_derivative)(const InertialLinks&, const double* q, const double* dq, double scale,
                              double* M, double* h, double* D, void* workspace) = nullptr;
  void (*lagrangian_gradient)(const InertialLinks&, const double* q, const double* dq,
                              double* gradient, void* workspace) = nullptr;
  void (*derivatives)(const InertialLinks&, const double* q, const double* dq, const double* ddq,
                      double* tau, double* by_q, double* by_dq, double* M,
                      void* workspace) = nullptr;
  bool (*forward_dynamics)(const InertialLinks&, const double* q, const double* dq,
                           const double* tau, double* ddq, double* M, void* workspace) = nullptr;
  bool (*forward_derivatives)(const InertialLinks&, const double* q, const double* dq,
                              const double* tau, double* ddq, double* by_q, double* by_dq,
                              double* by_tau, void* workspace) = nullptr;
  void (*regressor)(const Links&, const double* q, const double* dq, const double* ddq, double* Y,
                    void* workspace) = nullptr;
  // Batches: samples in lanes.
  int lanes = 0;
  std::size_t (*batch_workspace)(const Links&) = nullptr;  ///< [bytes], as those above
  /// Writes the regressor of the joints whose matrix is not null.
  void (*batch_regressor)(const Links&, const BatchInput&, const ColumnsByJoint<double>&,
                          void* workspace) = nullptr;
  /// Writes tau, (rows x n).
  void (*batch_torques)(const InertialLinks&, const BatchInput&, double* tau,
                        void* workspace) = nullptr;
  /// Writes 3 n matrices (rows x n), one after the other: dtau / dx_d, x = (q, dq, ddq).
  void (*batch_derivatives)(const InertialLinks&, const BatchInput&, double* out,
                            void* workspace) = nullptr;
  /// Derivatives of the sum of weights times regressor along q, dq and ddq: (rows x 3 n).
  void (*batch_gradient)(const Links&, const BatchInput&, const ColumnsByJoint<const double>&,
                         double* out, void* workspace) = nullptr;
};

ArmKernels arm_kernels_baseline();
ArmKernels arm_kernels_avx2();
ArmKernels arm_kernels_avx512();

/// Kernels of the widest instruction set of this processor.
const ArmKernels& arm_kernels();

}  // namespace veridyn
