#pragma once

#include <cstddef>

// Counts what is taken from the heap, inside compiled libraries too. Include it in exactly one
// source of a test binary: it defines malloc. Under the address sanitizer, which brings its own
// malloc, counting is off.

#if defined(__SANITIZE_ADDRESS__)
#define VERIDYN_COUNTS_MALLOC 0
#else
#define VERIDYN_COUNTS_MALLOC 1
#endif

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
