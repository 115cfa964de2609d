#include "filter_sweep_kernels.hpp"

namespace veridyn {

// Compiled with -mavx2 -mfma -mavx512f -mavx512dq -mavx512vl on x86.
FilterKernels filter_kernels_avx512() {
#if defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512VL__) && defined(__FMA__)
  struct Avx512;
  return FilterLoops<Pack<8, Avx512>>::kernels();
#else
  return {};
#endif
}

}  // namespace veridyn
