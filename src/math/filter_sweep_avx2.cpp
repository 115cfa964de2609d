#include "filter_sweep_kernels.hpp"

namespace veridyn {

// Compiled with -mavx2 -mfma on x86.
FilterKernels filter_kernels_avx2() {
#if defined(__AVX2__) && defined(__FMA__)
  struct Avx2;
  return FilterLoops<Pack<4, Avx2>>::kernels();
#else
  return {};
#endif
}

}  // namespace veridyn
