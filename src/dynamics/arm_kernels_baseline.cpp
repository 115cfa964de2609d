#include "arm_kernel_loops.hpp"

namespace veridyn {

// Two lanes are what every 64-bit x86 and ARM processor has.
ArmKernels arm_kernels_baseline() {
  struct Baseline;
  return ArmKernelLoops<2, Baseline>::kernels();
}

}  // namespace veridyn
