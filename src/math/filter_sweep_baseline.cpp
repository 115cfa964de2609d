#include "filter_sweep_kernels.hpp"

namespace veridyn {

// Every 64-bit x86 and ARM processor has vectors of two doubles.
FilterKernels filter_kernels_baseline() {
  struct Baseline;
  return FilterLoops<Pack<2, Baseline>>::kernels();
}

}  // namespace veridyn
