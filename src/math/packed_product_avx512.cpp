#include "packed_product_kernels.hpp"

namespace veridyn {

// Compiled with -mavx2 -mfma -mavx512f -mavx512dq -mavx512vl on x86.
void (*packed_product_avx512())(const PackedBlocks&) {
#if defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512VL__) && defined(__FMA__)
  return &packed_product<2>;
#else
  return nullptr;
#endif
}

}  // namespace veridyn
