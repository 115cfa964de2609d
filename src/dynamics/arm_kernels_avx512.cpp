#include "arm_kernel_loops.hpp"

namespace veridyn {

// Compiled with -mavx2 -mfma -mavx512f -mavx512dq -mavx512vl on x86.
ArmKernels arm_kernels_avx512() {
#if defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512VL__) && defined(__FMA__)
  struct Avx512;
  return ArmKernelLoops<8, Avx512>::kernels();
#else
  return {};
#endif
}

}  // namespace veridyn
