#pragma once

#include <cstddef>
#include <cstdint>

namespace veridyn::dvrk {

/// Ticks of the boards' clock, 49.152 MHz, since any start.
using Ticks = std::int64_t;

/// Output of one motor channel to the arm.
struct MotorDrive {
  bool powered = false;       ///< the amplifier is on
  bool voltage_mode = false;  ///< `bits` is a voltage
  double bits = 0.0;          ///< command minus 0x8000; 0 while not powered
};

/// Motion of the arm at one channel.
struct ChannelMotion {
  double counts = 0.0;        ///< Encoder counts from any mechanical zero, with fractions
  double pot_bits = 32768.0;  ///< Reading of the ADC
  double current_bits = 0.0;  ///< measured minus 0x8000
};

/// Load on the motors of emulated boards: an arm, or none. Channel c of the board at index b has
/// the index kChannels * b + c.
class BoardLoad {
 public:
  virtual ~BoardLoad() = default;

  /// Advances by `seconds` under constant drives, and returns the motion of all channels.
  virtual void advance(double seconds, const MotorDrive* drives, ChannelMotion* motions,
                       std::size_t channels) noexcept = 0;
};

/// A load that never moves; every motor draws its commanded current.
class StandingLoad final : public BoardLoad {
 public:
  void advance(double seconds, const MotorDrive* drives, ChannelMotion* motions,
               std::size_t channels) noexcept override;
};

}  // namespace veridyn::dvrk
