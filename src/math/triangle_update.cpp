#include "triangle_update.hpp"

#include "processor.hpp"

namespace veridyn {
namespace {

TriangleKernels widest_triangle_kernels() {
  const InstructionSet isa = widest_instruction_set();
  // The processor is checked before each of these calls, since the functions are themselves compiled for its
  // instruction set.
  if (isa >= InstructionSet::kAvx512 && triangle_kernels_avx512().update != nullptr) return triangle_kernels_avx512();
  if (isa >= InstructionSet::kAvx2 && triangle_kernels_avx2().update != nullptr) return triangle_kernels_avx2();
  return triangle_kernels_baseline();
}

}  // namespace

const TriangleKernels& triangle_kernels() {
  static const TriangleKernels chosen = widest_triangle_kernels();
  return chosen;
}

}  // namespace veridyn
