#pragma once

#include <array>
#include <cstdint>

#include "veridyn/dvrk/protocol/bytes.hpp"
#include "veridyn/dvrk/protocol/encoder_words.hpp"
#include "veridyn/dvrk/protocol/protocol.hpp"
#include "veridyn/dvrk/protocol/status.hpp"

namespace veridyn::dvrk {

struct ChannelFeedback {
  std::uint16_t pot = 0;      ///< bits of the ADC
  std::uint16_t current = 0;  ///< bits of the ADC; 0x8000 is no current
  EncoderWords encoder;
  MotorStatus motor;  ///< Rev 8 on
};

/// One real-time block read: specification 9.
struct BoardFeedback {
  std::uint32_t timestamp = 0;  ///< ticks since the previous one, minus 1
  Status status;
  DigitalInputs digital;
  Temperatures temperature;
  std::array<ChannelFeedback, kChannels> channel;

  double seconds() const { return (timestamp + 1.0) / kTicksPerSecond; }
};

/// Reads read_quadlets(firmware) quadlets; missing ones are zero.
BoardFeedback decode_feedback(QuadletView block, int firmware) noexcept;

/// Writes read_quadlets(firmware) quadlets, as far as `out` has space.
void encode_feedback(const BoardFeedback& feedback, int firmware, QuadletSpan out) noexcept;

}  // namespace veridyn::dvrk
