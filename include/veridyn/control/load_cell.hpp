#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "veridyn/control/force_law.hpp"

namespace veridyn {

/// From a converter's counts to newtons: force = scale * (raw - offset).
struct LoadCellCalibration {
  double offset = 0.0;  ///< [counts]
  double scale = 1.0;   ///< [N/count]
  double offset_interval = 0.0, scale_interval = 0.0;  ///< halves of the 95 % intervals
  double residual = 0.0;     ///< [N] root mean square of the weights' means from the line
  double noise = 0.0;        ///< [N] standard deviation of single readings about their mean
  double nonlinearity = 0.0; ///< [N] largest |mean - line|; NaN with two weights
  int weights = 0;
};

/// Readings under known forces, several of each: least squares over the means of the weights, with
/// intervals by Student's t from the residuals of the means (three weights or more) or from the
/// scatter within them (two).
/// @param force, raw  (readings) [N], [counts].
/// @throws InvalidInput  fewer than two different forces, lists of different lengths, all readings
///                       alike.
LoadCellCalibration calibrate_load_cell(const std::vector<double>& force,
                                        const std::vector<double>& raw);

/// YAML: offset, scale and the intervals. @throws InvalidInput  as usual for files.
LoadCellCalibration read_load_cell(const std::string& path);
std::string load_cell_text(const LoadCellCalibration& calibration);

/// How a converter speaks.
enum class LoadCellFormat {
  /// Lines whose last field is the reading: "8388607", "0.1,512", "HX711 reading: 8388607". Numbers
  /// may stand before it, and a name that a colon or an equals sign ends; any other line is none.
  kText,
  kBinary  ///< frames of 10 bytes: A5 5A, number (uint16), raw (int32), CRC-16/CCITT-FALSE of the
           ///< six bytes before it (uint16); all little-endian
};

/// Readings out of a stream of bytes, whatever stands between them: noise, cut lines, frames whose
/// CRC is wrong. Nothing allocates.
class LoadCellDecoder {
 public:
  explicit LoadCellDecoder(LoadCellFormat format) : format_(format) {}

  /// Takes one byte. @returns true where it ends a reading, which raw() then is.
  bool take(std::uint8_t byte) noexcept;
  double raw() const { return raw_; }
  long refused() const { return refused_; }  ///< lines or frames that were none

 private:
  bool take_text(std::uint8_t byte) noexcept;
  bool take_binary(std::uint8_t byte) noexcept;

  LoadCellFormat format_;
  std::array<char, 96> line_{};
  std::size_t length_ = 0;
  bool overlong_ = false;
  bool begun_ = false;  // the first line may be cut
  double raw_ = 0.0;
  long refused_ = 0;
};

/// CRC-16/CCITT-FALSE: polynomial 0x1021, start 0xFFFF.
std::uint16_t crc16(const std::uint8_t* bytes, std::size_t count) noexcept;

/// Whatever gives readings: a serial line, UDP, a scenario's sensor.
class ForceSource {
 public:
  virtual ~ForceSource() = default;
  /// Takes what has arrived up to the next reading, without waiting. @returns how many readings
  /// that were, 0 where nothing more is there; raw() is the latest.
  virtual int poll() noexcept = 0;
  virtual double raw() const noexcept = 0;
  /// [s] for which the latest reading lay ready before it was taken, as far as the system tells.
  virtual double lay() const noexcept { return 0.0; }
  virtual bool connected() const noexcept { return true; }
  virtual long refused() const noexcept { return 0; }
};

/// "serial:/dev/ttyUSB0[:115200][:text|binary]" or "udp:[ADDRESS:]PORT[:text|binary]", which listens
/// on 127.0.0.1 unless another address of this machine is given. The first sender has a port until
/// it is silent for a second: what others send is not taken.
/// @throws InvalidInput  another form, a port that cannot be opened.
std::unique_ptr<ForceSource> open_force_source(const std::string& name);

/// Why a channel is not to be trusted.
enum class ForceState {
  kWaiting,  ///< nothing has come yet
  kGood,
  kDead,   ///< nothing new for longer than ForceChannelOptions::largest_silence
  kStuck,  ///< the same counts for longer than stuck_after, though they keep coming
  kRange,  ///< beyond the range of the cell or its converter
  kNoisy   ///< too large a share of what comes cannot be used: the line is damaged
};
const char* describe(ForceState state);

struct ForceChannelOptions {
  LoadCellCalibration calibration;
  double largest_silence = 0.015;  ///< [s]; with a cycle of 1 ms a dead line is found within 16 ms
  double stuck_after = 0.015;      ///< [s] of readings that are alike to the last bit; 0: no watch
  int stuck_readings = 5;          ///< and at least so many
  double range = 200.0;            ///< [N] readings beyond it are not given
  /// [N] between two readings; a first one that is farther off waits for a second that agrees with
  /// it, and is not given without: a digit got lost. Infinite: no watch.
  double largest_jump = std::numeric_limits<double>::infinity();
  /// Share of lines, frames and readings that cannot be used, over noisy_window of them; beyond it
  /// the line is damaged. One of 100 is a line that lost a byte, not a cable that is loose.
  double noisy_share = 0.05;
  int noisy_window = 100;
  double cutoff = 0.0;             ///< [Hz] of a first-order low-pass; 0: none
  double latency = 0.0;            ///< [s] from the cell to the line's end, as far as known
};

/// A source, calibrated, filtered and watched: what a control loop reads once a cycle. Nothing
/// allocates, throws or blocks after the constructor.
class ForceChannel {
 public:
  ForceChannel(std::unique_ptr<ForceSource> source, const ForceChannelOptions& options);

  /// @param now  [s] on any clock that goes on evenly.
  ForceReading update(double now) noexcept;

  ForceState state() const { return state_; }
  /// Of the filter and the line together, at low frequency [s]: for stability analyses.
  double delay() const;
  double unfiltered() const { return force_; }  ///< [N] of the latest reading
  double believed() const { return last_raw_; }         ///< raw of the latest reading that was given
  long beyond_range() const { return beyond_range_; }  ///< readings that were not given
  long jumps() const { return jumps_; }                ///< likewise
  const ForceSource& source() const { return *source_; }

 private:
  void take(int fresh, double at) noexcept;
  bool is_believed(double force) noexcept;
  void count(long good, long bad) noexcept;

  std::unique_ptr<ForceSource> source_;
  ForceChannelOptions options_;
  ForceState state_ = ForceState::kWaiting;
  double force_ = 0.0, filtered_ = 0.0, last_raw_ = 0.0;
  double heard_ = 0.0, changed_ = 0.0;
  double begun_ = std::numeric_limits<double>::quiet_NaN();
  double waiting_ = 0.0;  // [N] of a jump that a second reading may confirm
  bool waits_ = false, beyond_ = false, noisy_ = false;
  long number_ = -1, beyond_range_ = 0, jumps_ = 0, refused_ = 0;
  long good_ = 0, bad_ = 0;  // of the window
  int alike_ = 0;
};

}  // namespace veridyn
