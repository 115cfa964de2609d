#include "filter_sweep.hpp"

#include "processor.hpp"

namespace veridyn {
namespace {

FilterKernels widest() {
  const InstructionSet isa = widest_instruction_set();
  const FilterKernels avx512 = filter_kernels_avx512();
  const FilterKernels avx2 = filter_kernels_avx2();
  if (isa >= InstructionSet::kAvx512 && avx512.run != nullptr) return avx512;
  if (isa >= InstructionSet::kAvx2 && avx2.run != nullptr) return avx2;
  return filter_kernels_baseline();
}

}  // namespace

const FilterKernels& filter_kernels() {
  static const FilterKernels chosen = widest();
  return chosen;
}

}  // namespace veridyn
