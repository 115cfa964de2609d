#pragma once

namespace veridyn {

/// Gives this thread real-time priority (SCHED_FIFO), for loops with a fixed cycle that release the processor
/// in each.
/// @param priority  1 to 99. @returns true if the system allowed it.
bool set_real_time_priority(int priority) noexcept;

/// Locks the memory of this process, so that a loop never waits for a page; the stack is touched in advance.
/// Memory that is allocated later is locked when it is first touched. @returns true if the system allowed it.
bool lock_memory() noexcept;

}  // namespace veridyn
