#include "state_kernels.hpp"

namespace veridyn {

// Two lanes are what every 64-bit x86 and ARM processor has.
StateKernels state_kernels_baseline() {
  struct Baseline;
  return StateLoops<Pack<2, Baseline>>::kernels();
}

}  // namespace veridyn
