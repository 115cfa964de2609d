#pragma once

#include <limits>
#include <memory>
#include <optional>

namespace veridyn {

/// A load cell and its converter.
struct ForceSensorOptions {
  double rate = 500.0;  ///< [Hz] rate of the samples
  double delay = 0.0;   ///< [s] time from a sample to its arrival
  double noise = 0.0;   ///< [N] standard deviation of white noise on every sample
  double step = 0.0;    ///< [N] samples are multiples of it; 0: exact
  unsigned seed = 1;
  /// Faults, [s] since the start: from then on the reading repeats its last value (stuck), or no
  /// samples arrive (stale).
  double stuck_from = std::numeric_limits<double>::infinity();
  double stale_from = std::numeric_limits<double>::infinity();
  /// From jump_from on, readings have an error of jump_by [N], which grows by `drift` [N/s].
  double jump_from = std::numeric_limits<double>::infinity();
  double jump_by = 0.0;
  double drift = 0.0;
};

/// The latest sample that has arrived.
struct ForceSample {
  double force = 0.0;  ///< [N] reading
  double time = 0.0;   ///< [s] time at which it was taken
  std::optional<long> number{};  ///< sequence number; nullopt: no sample has arrived
};

/// Simulates a force sensor. Call it once per control period, in order of time; nothing allocates
/// after the constructor.
class ForceSensor {
 public:
  static constexpr double kMostUnderWay = 1e6;  ///< largest number of samples under delay; all of them are stored

  /// @param longest_period  [s] between calls.
  /// @throws InvalidInput  a rate that is not above zero, a delay, noise or step below zero, more than
  ///   kMostUnderWay samples under delay.
  explicit ForceSensor(const ForceSensorOptions& options, double longest_period = 0.01);
  ~ForceSensor();
  ForceSensor(ForceSensor&&) noexcept;
  ForceSensor& operator=(ForceSensor&&) noexcept;

  /// @param time, force  present time [s] and true force [N].
  ForceSample read(double time, double force) noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace veridyn
