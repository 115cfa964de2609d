#pragma once

#include <functional>

namespace veridyn {

/// Calls body(i) for i = 0 .. count - 1 on up to `threads` threads (0: one per core); returns when
/// all are done, and rethrows the first exception.
void parallel_for(int count, int threads, const std::function<void(int)>& body);

/// `threads`, or the number of cores where that is 0.
int number_of_threads(int threads);

/// Threads available to each of `count` pieces of work while parallel_for() runs them.
int threads_of_each(int count, int threads);

}  // namespace veridyn
