#pragma once

#include <string>

#include "recordings/raw_recording.hpp"
#include "veridyn/recordings/signal_choice.hpp"

namespace veridyn::bags {

/// All topics of a bag, those decoded that hold joints' signals or plain numbers or that the choice
/// names.
/// @throws InvalidInput  see read_bag().
recordings::RawRecording read_bag_recording(const std::string& path, const SignalChoice& choice);

}  // namespace veridyn::bags
