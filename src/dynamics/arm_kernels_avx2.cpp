#include "arm_kernel_loops.hpp"

namespace veridyn {

// Compiled with -mavx2 -mfma on x86.
ArmKernels arm_kernels_avx2() {
#if defined(__AVX2__) && defined(__FMA__)
  struct Avx2;
  return ArmKernelLoops<4, Avx2>::kernels();
#else
  return {};
#endif
}

}  // namespace veridyn
