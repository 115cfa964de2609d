#include "regressor_batch_kernels.hpp"

namespace veridyn {

// Two lanes are what every 64-bit x86 and ARM processor has.
BatchKernels batch_kernels_baseline() {
  struct Baseline;
  return BatchLoops<Pack<2, Baseline>>::kernels();
}

}  // namespace veridyn
