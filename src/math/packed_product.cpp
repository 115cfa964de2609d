#include <Eigen/Core>
#include <algorithm>

#include "math/packed_product.hpp"
#include "math/processor.hpp"

namespace veridyn {
namespace {

// Smallest number of multiplications for which AVX-512 is used. If it were always used, a feasible fit of
// three bodies, whose largest products are 30 x 30 x 30, would take 1.11 of the time with AVX2, and one of 30
// bodies 0.84; with this threshold fits of 3, 10, 30 and 100 bodies take 0.99, 0.99, 0.95 and 0.77.
[[maybe_unused]] constexpr long kWideFrom = 30 * 30 * 30 + 1;

using PackedProduct = void (*)(const PackedBlocks&);

// The kernel for an instruction set; null if the processor has no wider vectors than the build.
[[maybe_unused]] PackedProduct product_for(InstructionSet wanted) {
  const InstructionSet isa = std::min(wanted, widest_instruction_set());
  if (isa >= InstructionSet::kAvx512 && packed_product_avx512() != nullptr) return packed_product_avx512();
  return isa >= InstructionSet::kAvx2 ? packed_product_avx2() : nullptr;
}

}  // namespace
}  // namespace veridyn

// The innermost product of all Eigen products and solutions. Its specialization must be compiled in a file that
// does not include decompositions.hpp, which declares it as compiled elsewhere.
namespace Eigen {
#if EIGEN_VERSION_AT_LEAST(3, 4, 0) && !EIGEN_VERSION_AT_LEAST(3, 4, 90)
namespace internal {

template <typename I>
using Blocks = blas_data_mapper<double, I, ColMajor, Unaligned, 1>;
template <typename I>
using Gebp = gebp_kernel<double, double, I, Blocks<I>, gebp_traits<double, double>::mr, gebp_traits<double, double>::nr, false, false>;

#if defined(__SSE2__) && !defined(__AVX__)
// Calls the kernel for the processor if that has more than the two lanes of this build; otherwise Eigen's own,
// instantiated for another index type.
template <>
EIGEN_DONT_INLINE void Gebp<Index>::operator()(const Blocks<Index>& res, const double* A,
                                               const double* B, Index rows, Index depth, Index cols,
                                               double alpha, Index strideA, Index strideB,
                                               Index offsetA, Index offsetB) {
  static const veridyn::PackedProduct small = veridyn::product_for(veridyn::InstructionSet::kAvx2);
  static const veridyn::PackedProduct large = veridyn::product_for(veridyn::InstructionSet::kAvx512);
  if (rows <= 0 || cols <= 0) return;
  const veridyn::PackedProduct wide = rows * cols * depth < veridyn::kWideFrom ? small : large;
  double* const C = &res(0, 0);
  if (wide != nullptr) {
    wide({A, B, C, res.stride(), rows, depth, cols, strideA < 0 ? depth : strideA,
          strideB < 0 ? depth : strideB, offsetA, offsetB, alpha});
  } else {
    Gebp<long long>()(Blocks<long long>(C, res.stride()), A, B, rows, depth, cols, alpha, strideA,
                      strideB, offsetA, offsetB);
  }
}
#else
template struct gebp_kernel<double, double, Index, Blocks<Index>, gebp_traits<double, double>::mr, gebp_traits<double, double>::nr, false, false>;
#endif

}  // namespace internal
#endif
}  // namespace Eigen
