#pragma once

namespace veridyn {

/// Gives this thread real-time priority (SCHED_FIFO), where the system allows it: for loops with a
/// fixed cycle that release the processor in each.
/// @param priority  1 to 99. @returns whether it was allowed.
bool set_real_time_priority(int priority) noexcept;

/// Locks the memory of this process, so that a loop never waits for a page; the stack is touched in
/// advance. Later allocations are locked when they are first touched. @returns true if the system
/// allowed it.
bool lock_memory() noexcept;

}  // namespace veridyn
