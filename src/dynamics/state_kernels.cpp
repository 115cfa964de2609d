#include "math/processor.hpp"
#include "state_links.hpp"

namespace veridyn {
namespace {

StateKernels widest() {
  const InstructionSet isa = widest_instruction_set();
  // Even to ask for kernels runs code of their instruction set.
  if (isa >= InstructionSet::kAvx512 && state_kernels_avx512().inverse_dynamics != nullptr) return state_kernels_avx512();
  if (isa >= InstructionSet::kAvx2 && state_kernels_avx2().inverse_dynamics != nullptr) return state_kernels_avx2();
  return state_kernels_baseline();
}

}  // namespace

const StateKernels& state_kernels() {
  static const StateKernels chosen = widest();
  return chosen;
}

}  // namespace veridyn
