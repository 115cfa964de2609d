#pragma once

#include "recordings/bags/file_kind.hpp"
#include "recordings/signals/raw_recording.hpp"
#include "veridyn/recordings/signal_choice.hpp"

namespace veridyn::bags {

/// Reads all topics of a bag. Decodes those with joint signals or plain numbers, and those that the choice
/// names.
/// @throws InvalidInput  see read_bag().
recordings::RawRecording read_bag_recording(const recordings::OpenedFile& file,
                                            const SignalChoice& choice);

}  // namespace veridyn::bags
