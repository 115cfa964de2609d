#pragma once

namespace veridyn {

/// Instruction sets that kernels are compiled for; each includes those before it.
enum class InstructionSet {
  kBaseline,  ///< common to all processors of the architecture
  kAvx2,      ///< AVX2 and FMA, x86-64-v3
  kAvx512,    ///< AVX-512 F, DQ and VL
};

/// The widest instruction set of this processor; detected once.
InstructionSet widest_instruction_set();

}  // namespace veridyn
