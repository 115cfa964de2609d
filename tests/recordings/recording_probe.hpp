#pragma once

#include <string_view>

#include "veridyn/recordings/recording.hpp"

namespace veridyn {

/// Reads bytes as a file of whatever kind they look like, from container to signals.
/// @throws InvalidInput  and nothing else
Recording read_probe(std::string_view bytes);

/// The same, forgotten. @returns the number of positions and torques, 0 where they are refused.
long probe_recording(std::string_view bytes);

}  // namespace veridyn
