#include "dvrk/boards/board_session.hpp"

// Switching a session off, with confirmation by the boards.

namespace veridyn::dvrk {
namespace {

constexpr int kOffRepeats = 3;  // smallest number of times that "off" is sent
constexpr int kConfirmations = 2;
constexpr double kOffPause = 0.001;  // [s] time between repeats

}  // namespace

const char* describe(OffState state) {
  switch (state) {
    case OffState::kConfirmed:
      return "power is off";
    case OffState::kNotAsked:
      return "nothing was written";
    case OffState::kPowerOn:
      return "amplifiers are off, but a board still requests motor power";
    case OffState::kAmpsOn:
      return "an amplifier is still on";
    case OffState::kUnknown:
      return "a board does not say whether it is off";
  }
  return "";
}

// Reads status registers, because the last block may be outdated.
OffState BoardSession::off_state() noexcept {
  OffState worst = OffState::kConfirmed;
  for (int b = 0; b < bus_.boards(); ++b) {
    std::uint32_t word = 0;
    if (bus_.state() != BusState::kRunning || !bus_.read_register(b, address::kStatus, word) ||
        Status{word}.board() != bus_.info(b).id)
      return OffState::kUnknown;
    if ((word & control::kAmpsOff) != 0) {
      worst = OffState::kAmpsOn;
    } else if (Status{word}.power_requested() && worst == OffState::kConfirmed) {
      worst = OffState::kPowerOn;
    }
  }
  return worst;
}

OffState BoardSession::shutdown() noexcept {
  if (!started_ || listens()) return OffState::kNotAsked;
  power_off_asked_ = true;
  if (state_ != PowerState::kFault) enter(PowerState::kOff);
  const double until = link_.now() + options_.off_timeout;
  OffState seen = OffState::kUnknown;
  int confirmed = 0;  // confirmations in a row, since one reply may be corrupt
  for (int k = 0; k < kOffRepeats || (confirmed < kConfirmations && link_.now() < until); ++k) {
    bus_.switch_off(BoardBus::Off::kPower);
    if (k % 2 == 1 && bus_.state() == BusState::kRunning) {
      for (int b = 0; b < bus_.boards(); ++b) bus_.switch_off_by_register(b, BoardBus::Off::kPower);
    }
    link_.wait(kOffPause);
    if (bus_.state() != BusState::kRunning) bus_.read();  // searches for boards that have changed nodes
    if (k + 1 < kOffRepeats) continue;
    seen = off_state();
    confirmed = seen == OffState::kConfirmed ? confirmed + 1 : 0;
    if (seen == OffState::kUnknown) bus_.read();
  }
  return confirmed >= kConfirmations || seen != OffState::kConfirmed ? seen : OffState::kUnknown;
}

}  // namespace veridyn::dvrk
