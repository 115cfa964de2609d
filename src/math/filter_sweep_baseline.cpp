#include "filter_sweep_kernels.hpp"

namespace veridyn {

// Two lanes are what every 64-bit x86 and ARM processor has.
FilterKernels filter_kernels_baseline() {
  struct Baseline;
  return FilterLoops<Pack<2, Baseline>>::kernels();
}

}  // namespace veridyn
