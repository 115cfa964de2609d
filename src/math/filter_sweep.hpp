#pragma once

namespace veridyn {

constexpr int kFilterLanes = 8;  ///< columns that are filtered side by side

/// A second-order section as a state space: y = b0 x + s1, s1' = c1 x - a1 s1 + s2,
/// s2' = c2 x - a2 s1, which is the transposed direct form II without y in its loop.
struct FilterSection {
  double b0, c1, c2, a1, a2;
  double start1, start2;  ///< values of s1, s2 in the steady state for a constant input of one
};

/// Filters up to kFilterLanes columns forward and backward.
struct FilterSweep {
  const FilterSection* sections;
  int count;  ///< number of sections
  double* const* columns;  ///< one pointer for each lane in use; filtered in place
  int lanes;     ///< number of lanes in use
  long rows;
  long pad;      ///< rows of odd reflection at either end, below `rows`
  double* work;  ///< (rows + 2 pad) * kFilterLanes doubles, aligned to 64 bytes
};

struct FilterKernels {
  void (*run)(const FilterSweep& in) = nullptr;  ///< null: not compiled for this architecture
};

FilterKernels filter_kernels_baseline();
FilterKernels filter_kernels_avx2();
FilterKernels filter_kernels_avx512();

/// Kernels of the widest instruction set of this processor.
const FilterKernels& filter_kernels();

}  // namespace veridyn
