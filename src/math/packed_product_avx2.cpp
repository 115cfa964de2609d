#include "packed_product_kernels.hpp"

namespace veridyn {

// Compiled with -mavx2 -mfma on x86.
void (*packed_product_avx2())(const PackedBlocks&) {
#if defined(__AVX2__) && defined(__FMA__)
  return &packed_product<1>;
#else
  return nullptr;
#endif
}

}  // namespace veridyn
