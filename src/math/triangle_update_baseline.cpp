#include "triangle_update_kernels.hpp"

namespace veridyn {

// Two lanes are what every 64-bit x86 and ARM processor has.
TriangleKernels triangle_kernels_baseline() {
  struct Baseline;
  return TriangleLoops<Pack<2, Baseline>>::kernels();
}

}  // namespace veridyn
