#pragma once

#include <functional>

namespace veridyn {

/// Calls body(i) for i = 0 .. count - 1 on up to `threads` threads (0: one per core); returns when
/// all are done. The first exception is thrown again here.
void parallel_for(int count, int threads, const std::function<void(int)>& body);

/// `threads`, or where that is 0 the number of cores.
int number_of_threads(int threads);

/// Threads that each of so many pieces of work may use for itself while parallel_for() runs them.
int threads_of_each(int count, int threads);

}  // namespace veridyn
