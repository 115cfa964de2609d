#pragma once

#include <cmath>
#include <cstdint>

namespace veridyn::dvrk {

/// value = offset + scale * input, the only conversion in configuration files.
struct LinearScale {
  double scale = 1.0;
  double offset = 0.0;

  double operator()(double input) const noexcept { return offset + scale * input; }
  double inverse(double value) const noexcept { return (value - offset) / scale; }
};

// The converters of an uncalibrated QLA board.

/// Command of the digital-to-analog converter: 6.25 A at either end, 5242.88 bits per ampere.
constexpr LinearScale kNominalAmpsToBits{32768.0 / 6.25, 32768.0};
/// Measured motor current.
constexpr LinearScale kNominalBitsToAmps{12.5 / 65536.0, -6.25};
/// Potentiometer, 0 .. 4.5 V.
constexpr LinearScale kNominalBitsToVolts{4.5 / 65536.0, 0.0};

/// The nearest word of 16 bits, limited to its range; `zero` if the value is NaN.
inline std::uint16_t nearest_word(double value, std::uint16_t zero) noexcept {
  if (std::isnan(value)) return zero;
  if (value <= 0.0) return 0;
  return value >= 65535.0 ? std::uint16_t{65535} : static_cast<std::uint16_t>(std::lround(value));
}

/// [degC] of one sensor's byte; NaN if the sensor gives no value (0xFF).
inline double temperature(std::uint8_t byte) noexcept {
  return byte == 0xFF ? std::nan("") : 0.5 * byte;
}

}  // namespace veridyn::dvrk
