#include "triangle_update_kernels.hpp"

namespace veridyn {

// Compiled with -mavx2 -mfma on x86.
TriangleKernels triangle_kernels_avx2() {
#if defined(__AVX2__) && defined(__FMA__)
  struct Avx2;
  return TriangleLoops<Pack<4, Avx2>>::kernels();
#else
  return {};
#endif
}

}  // namespace veridyn
