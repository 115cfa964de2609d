#include "triangle_update.hpp"

#include "processor.hpp"

namespace veridyn {
namespace {

TriangleKernels widest() {
  const InstructionSet isa = widest_instruction_set();
  const TriangleKernels avx512 = triangle_kernels_avx512();
  const TriangleKernels avx2 = triangle_kernels_avx2();
  if (isa >= InstructionSet::kAvx512 && avx512.update != nullptr) return avx512;
  if (isa >= InstructionSet::kAvx2 && avx2.update != nullptr) return avx2;
  return triangle_kernels_baseline();
}

}  // namespace

const TriangleKernels& triangle_kernels() {
  static const TriangleKernels chosen = widest();
  return chosen;
}

}  // namespace veridyn
