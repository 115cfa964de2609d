#include "motion_gradient_kernels.hpp"

namespace veridyn {

// Two lanes are what every 64-bit x86 and ARM processor has.
BatchKernels batch_kernels_baseline() {
  struct Baseline;
  return GradientLoops<Pack<2, Baseline>>::kernels();
}

}  // namespace veridyn
