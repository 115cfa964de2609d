#pragma once

#include <functional>
#include <string>
#include <vector>

#include "emulator/board_emulator.hpp"

namespace veridyn::dvrk {

/// An event on emulated boards at a given time: "emergency-stop@2.5", "current:6.1=0.4@3".
struct BoardEvent {
  std::string words;  ///< text of the event without the time
  double time = 0.0;  ///< [s] since the start
  std::function<void(BoardEmulator&)> happen;
};

/// The events in order of time. @throws InvalidInput  an unknown name, a board that is not
/// emulated, or a missing number.
std::vector<BoardEvent> board_events(const std::vector<std::string>& words,
                                     BoardEmulator& emulator);

/// The available names, one per line with their effect, for --help.
std::string board_event_help();

}  // namespace veridyn::dvrk
