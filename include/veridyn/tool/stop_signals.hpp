#pragma once

#include <atomic>

namespace veridyn::cli {

/// True after a signal that requests an end (INT, TERM, HUP, QUIT, PIPE), since the first call of
/// catch_signals().
const std::atomic<bool>& stop_requested();
void catch_signals();  ///< from now on these signals set stop_requested()

}  // namespace veridyn::cli
