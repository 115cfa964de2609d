#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/control/force_law.hpp"

namespace veridyn {

/// Conversion of a converter's counts to newtons: force = scale * (raw - offset).
struct LoadCellCalibration {
  double offset = 0.0;  ///< [counts] reading without force
  double scale = 1.0;   ///< [N/count] slope of the line
  double offset_interval = 0.0, scale_interval = 0.0;  ///< half widths of the 95 % intervals
  double residual = 0.0;     ///< [N] root mean square of the weights' means from the line
  double noise = 0.0;        ///< [N] standard deviation of single readings about their mean
  double nonlinearity = 0.0; ///< [N] largest |mean - line|; NaN with two weights
  int weights = 0;
};

/// Calibrates from several readings under each of several known forces: least squares over the
/// means of the weights, with intervals by Student's t from the residuals of the means (three
/// weights or more) or from the scatter within them (two).
/// @param force, raw  (readings) [N], [counts].
/// @throws InvalidInput  fewer than two different forces, lists of different lengths, or identical
/// readings.
LoadCellCalibration calibrate_load_cell(const std::vector<double>& force,
                                        const std::vector<double>& raw);

/// Reads YAML with offset [counts], scale [N/count] and intervals. @throws InvalidInput  the file is missing or
/// malformed.
LoadCellCalibration read_load_cell(const std::string& path);
/// YAML text that read_load_cell() reads.
std::string load_cell_text(const LoadCellCalibration& calibration);

/// Data format of a converter.
enum class LoadCellFormat {
  /// Lines whose last field is the reading: "8388607", "0.1,512", "HX711 reading: 8388607". Other
  /// numbers may precede it, and so may a name that ends with a colon or an equals sign; other
  /// lines are refused.
  kText,
  kBinary  ///< frames of 10 bytes: A5 5A, number (uint16), raw (int32), CRC-16/CCITT-FALSE of the
           ///< six bytes before it (uint16); all little-endian
};

/// Decodes readings from a stream of bytes and skips damaged data: noise, incomplete lines, frames with a
/// wrong CRC. Nothing allocates.
class LoadCellDecoder {
 public:
  explicit LoadCellDecoder(LoadCellFormat format) : format_(format) {}

  /// Processes one byte. @returns true if it completes a reading, which raw() then returns.
  bool add_byte(std::uint8_t byte) noexcept;
  /// [counts] latest reading.
  double raw() const { return raw_; }
  long rejected_readings() const { return refused_; }  ///< lines or frames that were no readings

 private:
  bool decode_text(std::uint8_t byte) noexcept;  ///< both as add_byte()
  bool decode_binary(std::uint8_t byte) noexcept;

  LoadCellFormat format_;
  std::array<char, 96> line_{};
  std::size_t length_ = 0;
  bool overlong_ = false;
  bool begun_ = false;  // false during the first line, which may be incomplete
  double raw_ = 0.0;
  long refused_ = 0;
};

/// CRC-16/CCITT-FALSE: polynomial 0x1021, start 0xFFFF.
std::uint16_t crc16(const std::uint8_t* bytes, std::size_t count) noexcept;

/// A source of readings: a serial line, UDP, or the sensor of a scenario.
class ForceSource {
 public:
  virtual ~ForceSource() = default;
  /// Takes the latest reading that has arrived, without waiting. @returns the number of readings since the
  /// previous call; raw() is the latest.
  virtual int poll() noexcept = 0;
  virtual double raw() const noexcept = 0;  ///< latest reading, before LoadCellCalibration
  /// [s] between the arrival of the latest reading and its poll(), as far as the system knows.
  virtual double queue_delay() const noexcept { return 0.0; }
  virtual bool connected() const noexcept { return true; }
  virtual long rejected_readings() const noexcept { return 0; }
};

/// Opens "serial:/dev/ttyUSB0[:115200][:text|binary]" or "udp:[ADDRESS:]PORT[:text|binary]", which
/// listens on 127.0.0.1 unless another address of this machine is given. A port accepts only its
/// first sender until that one has been silent for a second.
/// @throws InvalidInput  the name has another form, or the port cannot be opened.
std::unique_ptr<ForceSource> open_force_source(const std::string& name);

/// Validity of a channel, or the reason why its readings must not be used.
enum class ForceState {
  kWaiting,  ///< no reading has arrived
  kGood,
  kDead,   ///< no new reading for longer than ForceChannelOptions::largest_silence
  kStuck,  ///< readings arrive, but with equal counts for longer than stuck_after
  kRange,  ///< the reading is beyond the range of the cell or its converter
  kNoisy   ///< too large a share of the data is unusable: the line is damaged
};
const char* describe(ForceState state);

struct ForceChannelOptions {
  LoadCellCalibration calibration;
  double largest_silence = 0.015;  ///< [s]; in a cycle of 1 ms a dead line is detected within 16 ms
  double stuck_after = 0.015;      ///< [s] longest duration of equal readings; 0: no check
  int stuck_readings = 5;          ///< smallest number of equal readings of a stuck cell
  double range = 200.0;            ///< [N] readings beyond it are discarded
  /// [N] largest step between two readings. A larger step is accepted only after a second reading confirms
  /// it, because a lost digit would cause the same step. Infinite: no check.
  double largest_jump = std::numeric_limits<double>::infinity();
  /// Share of unusable lines, frames and readings among the last noisy_window, above which the line counts as
  /// damaged. One of 100 is a lost byte, not a loose cable.
  double noisy_share = 0.05;
  int noisy_window = 100;
  double cutoff = 0.0;             ///< [Hz] cutoff of a first-order low-pass; 0: none
  double latency = 0.0;            ///< [s] delay from the cell to the end of the line, as far as known
};

/// A calibrated, filtered and checked force, read by a control loop once a cycle. Nothing
/// allocates, throws or blocks after the constructor.
class ForceChannel {
 public:
  ForceChannel(std::unique_ptr<ForceSource> source, const ForceChannelOptions& options);

  /// @param now  [s] on any steady clock.
  ForceReading update(double now) noexcept;

  ForceState state() const { return state_; }
  /// [s] delay of filter and line together at low frequency, for stability analyses.
  double delay() const;
  double unfiltered() const { return force_; }  ///< [N] latest reading before the low-pass
  double last_accepted() const { return last_raw_; }  ///< raw value of the latest accepted reading
  /// Readings discarded because of their range.
  long beyond_range() const { return beyond_range_; }
  long jumps() const { return jumps_; }                ///< readings discarded because of their step
  const ForceSource& source() const { return *source_; }

 private:
  void accept_readings(int fresh, double at) noexcept;
  bool is_accepted(double force) noexcept;
  void count_readings(long good, long bad) noexcept;

  std::unique_ptr<ForceSource> source_;
  ForceChannelOptions options_;
  ForceState state_ = ForceState::kWaiting;
  double force_ = 0.0, filtered_ = 0.0, last_raw_ = 0.0;
  double heard_ = 0.0, changed_ = 0.0;
  double begun_ = std::numeric_limits<double>::quiet_NaN();
  double waiting_ = 0.0;  // [N] reading that a second one has to confirm
  bool waits_ = false, beyond_ = false, noisy_ = false;
  std::optional<long> number_;  // sequence number of the last sample
  long beyond_range_ = 0, jumps_ = 0, refused_ = 0;
  long good_ = 0, bad_ = 0;  // usable and unusable data in the present window
  int alike_ = 0;
};

}  // namespace veridyn
