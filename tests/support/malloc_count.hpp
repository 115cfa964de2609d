#pragma once

#include <cstddef>

#include "support/sanitized.hpp"

// Counts what is taken from the heap, inside compiled libraries too. Include it in exactly one
// source of a test binary: it defines malloc. Under sanitizers counting is off.

#define VERIDYN_COUNTS_MALLOC !VERIDYN_SANITIZED

namespace veridyn {

inline long& malloc_count() {
  static thread_local long count = 0;
  return count;
}

}  // namespace veridyn

#if VERIDYN_COUNTS_MALLOC
extern "C" {
void* __libc_malloc(std::size_t size);                           // NOLINT: glibc's own name
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT

void* malloc(std::size_t size) noexcept {
  ++veridyn::malloc_count();
  return __libc_malloc(size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  ++veridyn::malloc_count();
  return __libc_memalign(alignment, size);
}
}
#endif
