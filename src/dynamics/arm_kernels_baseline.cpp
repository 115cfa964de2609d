#include "arm_kernel_loops.hpp"

namespace veridyn {

// Every 64-bit x86 and ARM processor has vectors of two doubles.
ArmKernels arm_kernels_baseline() {
  struct Baseline;
  return ArmKernelLoops<2, Baseline>::kernels();
}

}  // namespace veridyn
