#pragma once

#include <functional>

namespace veridyn {

/// Calls body(i) for i = 0 .. count - 1 on up to `threads` threads (0: one per core); returns when
/// all are done. The first exception is thrown again here.
void parallel_for(int count, int threads, const std::function<void(int)>& body);

}  // namespace veridyn
