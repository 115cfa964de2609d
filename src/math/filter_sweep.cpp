#include "filter_sweep.hpp"

#include "processor.hpp"

namespace veridyn {
namespace {

FilterKernels widest_filter_kernels() {
  const InstructionSet isa = widest_instruction_set();
  // The processor is checked before each of these calls, since the functions are themselves compiled for its
  // instruction set.
  if (isa >= InstructionSet::kAvx512 && filter_kernels_avx512().run != nullptr) return filter_kernels_avx512();
  if (isa >= InstructionSet::kAvx2 && filter_kernels_avx2().run != nullptr) return filter_kernels_avx2();
  return filter_kernels_baseline();
}

}  // namespace

const FilterKernels& filter_kernels() {
  static const FilterKernels chosen = widest_filter_kernels();
  return chosen;
}

}  // namespace veridyn
