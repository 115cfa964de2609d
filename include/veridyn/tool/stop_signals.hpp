#pragma once

#include <atomic>

namespace veridyn::cli {

/// Set by every signal that requests an end (INT, TERM, HUP, QUIT, PIPE), from the first call of
/// catch_signals() on.
const std::atomic<bool>& stop_requested();
void catch_signals();

}  // namespace veridyn::cli
