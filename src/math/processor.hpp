#pragma once

namespace veridyn {

/// Instruction sets that kernels are compiled for; each includes those before it.
enum class InstructionSet {
  kBaseline,  ///< what every processor of the architecture has
  kAvx2,      ///< AVX2 and FMA, x86-64-v3
  kAvx512,    ///< AVX-512 F, DQ and VL
};

/// The widest that this processor has; found once.
InstructionSet widest_instruction_set();

}  // namespace veridyn
