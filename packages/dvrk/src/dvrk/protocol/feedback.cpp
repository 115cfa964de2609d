#include "dvrk/protocol/feedback.hpp"

namespace veridyn::dvrk {
namespace {

// Index of the first word of each kind in a block read; there are four of each kind: specification 9.
enum Word : std::size_t {
  kAnalogAt = 4,
  kPositionAt = 8,
  kPeriodAt = 12,
  kQuarter1At = 16,
  kQuarter5At = 20,
  kRunningAt = 24,
  kMotorAt = 28
};

}  // namespace

BoardFeedback decode_feedback(QuadletView block, int firmware) noexcept {
  BoardFeedback f;
  f.timestamp = block[0];
  f.status.word = block[1];
  f.digital.word = block[2];
  f.temperature.word = block[3];
  for (std::size_t c = 0; c < kChannels; ++c) {
    ChannelFeedback& channel = f.channel[c];
    const std::uint32_t analog = block[kAnalogAt + c];
    channel.pot = static_cast<std::uint16_t>(analog >> 16);
    channel.current = static_cast<std::uint16_t>(analog);
    channel.encoder.position = block[kPositionAt + c];
    channel.encoder.period = block[kPeriodAt + c];
    channel.encoder.quarter1 = block[kQuarter1At + c];
    if (firmware >= 7) {
      channel.encoder.quarter5 = block[kQuarter5At + c];
      channel.encoder.running = block[kRunningAt + c];
    }
    if (firmware >= 8) channel.motor.word = block[kMotorAt + c];
  }
  return f;
}

void encode_feedback(const BoardFeedback& f, int firmware, QuadletSpan out) noexcept {
  out.set(0, f.timestamp);
  out.set(1, f.status.word);
  out.set(2, f.digital.word);
  out.set(3, f.temperature.word);
  for (std::size_t c = 0; c < kChannels; ++c) {
    const ChannelFeedback& channel = f.channel[c];
    out.set(kAnalogAt + c, (static_cast<std::uint32_t>(channel.pot) << 16) | channel.current);
    out.set(kPositionAt + c, channel.encoder.position);
    out.set(kPeriodAt + c, channel.encoder.period);
    out.set(kQuarter1At + c, channel.encoder.quarter1);
    if (firmware >= 7) {
      out.set(kQuarter5At + c, channel.encoder.quarter5);
      out.set(kRunningAt + c, channel.encoder.running);
    }
    if (firmware >= 8) out.set(kMotorAt + c, channel.motor.word);
  }
}

}  // namespace veridyn::dvrk
