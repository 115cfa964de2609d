#include "triangle_update_kernels.hpp"

namespace veridyn {

// Every 64-bit x86 and ARM processor has vectors of two doubles.
TriangleKernels triangle_kernels_baseline() {
  struct Baseline;
  return TriangleLoops<Pack<2, Baseline>>::kernels();
}

}  // namespace veridyn
