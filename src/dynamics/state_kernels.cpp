#include "math/processor.hpp"
#include "state_links.hpp"

namespace veridyn {
namespace {

StateKernels widest() {
  const InstructionSet isa = widest_instruction_set();
  const StateKernels avx512 = state_kernels_avx512();
  const StateKernels avx2 = state_kernels_avx2();
  if (isa >= InstructionSet::kAvx512 && avx512.inverse_dynamics != nullptr) return avx512;
  if (isa >= InstructionSet::kAvx2 && avx2.inverse_dynamics != nullptr) return avx2;
  return state_kernels_baseline();
}

}  // namespace

const StateKernels& state_kernels() {
  static const StateKernels chosen = widest();
  return chosen;
}

}  // namespace veridyn
