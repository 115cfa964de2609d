#pragma once

namespace veridyn {

/// Lets this thread run before all ordinary ones (first in, first out), where the system allows it:
/// for loops that have a cycle to keep and give the processor back in every one.
/// @param priority  1 to 99. @returns whether it was allowed.
bool take_real_time_priority(int priority) noexcept;

/// Keeps the memory of this process where it is, so that a loop never waits for a page of it; the
/// stack is touched in advance. Memory that is made later is kept as soon as it is touched.
/// @returns whether it was allowed.
bool lock_memory() noexcept;

}  // namespace veridyn
