#include "arm_kernels.hpp"

#include "math/processor.hpp"

namespace veridyn {
namespace {

ArmKernels widest_kernels() {
  const InstructionSet isa = widest_instruction_set();
  // The processor is checked before each of these functions is called, since they are themselves compiled for
  // its instruction set.
  if (isa >= InstructionSet::kAvx512 && arm_kernels_avx512().lanes > 0) return arm_kernels_avx512();
  if (isa >= InstructionSet::kAvx2 && arm_kernels_avx2().lanes > 0) return arm_kernels_avx2();
  return arm_kernels_baseline();
}

}  // namespace

const ArmKernels& arm_kernels() {
  static const ArmKernels chosen = widest_kernels();
  return chosen;
}

}  // namespace veridyn
