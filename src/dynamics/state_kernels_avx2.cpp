#include "state_kernels.hpp"

namespace veridyn {

// Compiled with -mavx2 -mfma on x86.
StateKernels state_kernels_avx2() {
#if defined(__AVX2__) && defined(__FMA__)
  struct Avx2;
  return StateLoops<Pack<4, Avx2>>::kernels();
#else
  return {};
#endif
}

}  // namespace veridyn
