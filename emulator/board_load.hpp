#pragma once

#include <cstddef>
#include <cstdint>

namespace veridyn::dvrk {

/// The clock of the boards, 49.152 MHz, since any start.
using Ticks = std::int64_t;

/// One motor channel as the arm behind it sees it.
struct MotorDrive {
  bool powered = false;       ///< the amplifier is on
  bool voltage_mode = false;  ///< `bits` is a voltage
  double bits = 0.0;          ///< command minus 0x8000; 0 while not powered
};

/// One channel as the board sees the arm.
struct ChannelMotion {
  double counts = 0.0;        ///< Encoder counts from any mechanical zero, with fractions
  double pot_bits = 32768.0;  ///< Reading of the ADC
  double current_bits = 0.0;  ///< measured minus 0x8000
};

/// What hangs on the motors of emulated boards: an arm, or nothing. Channel c of the board at
/// place b stands at index kChannels * b + c.
class BoardLoad {
 public:
  virtual ~BoardLoad() = default;

  /// Moves on by `seconds` under constant drives, and says where everything is.
  virtual void advance(double seconds, const MotorDrive* drives, ChannelMotion* motions,
                       std::size_t channels) noexcept = 0;
};

/// Nothing moves, and every motor draws what it is told.
class StandingLoad final : public BoardLoad {
 public:
  void advance(double seconds, const MotorDrive* drives, ChannelMotion* motions,
               std::size_t channels) noexcept override;
};

}  // namespace veridyn::dvrk
