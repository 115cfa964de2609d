#pragma once

#include <cstddef>
#include <vector>

namespace veridyn::internal {

/// Memory whose first double is aligned for the widest SIMD vectors; each copy owns its memory.
class AlignedWorkspace {
 public:
  explicit AlignedWorkspace(std::size_t bytes);
  double* get();

 private:
  std::vector<double> memory_;
};

}  // namespace veridyn::internal
