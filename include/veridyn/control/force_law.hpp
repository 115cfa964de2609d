#pragma once

#include <limits>
#include <optional>

namespace veridyn {

/// Law that corrects the length of a member by its force: x_f of thesis 7.7.2, the distance [m] by which its
/// ends move apart. With e = h_d - h_e, too little tension increases x_f.
struct ForceLaw {
  enum class Kind {
    kIncrement,    ///< 7.7.3: x_f moves by `increment` in the sign of e wherever |e| > deadband
    kProportional  ///< (7.12): x_f += gain * e, with the terms below that the thesis does not have
  };
  Kind kind = Kind::kProportional;
  double deadband = 0.0;   ///< [N] no change of x_f within it
  double increment = 0.0;  ///< [m] change of x_f per sample of the sensor
  /// K_f [m/(N s)]: per second, so that it does not depend on the sensor's rate
  double gain = 0.0;
  double proportional = 0.0;  ///< [m/N] proportional term in addition to the integral of (7.12)
  /// [s] damping term that the thesis does not have: the ends yield to the measured rate of the member's
  /// length, x_f - damping * dl/dt. With a follower of stiffness K it damps the member by K * damping.
  double damping = 0.0;
  double feed_forward = 0.0;  ///< [m/N] factor of h_d: 1 / K of an impedance follower
  double reach = 0.05;        ///< [m] largest |x_f|
  double stiffness = 0.0;  ///< [N/m] estimate of the member's stiffness, for the checks of the sensor; 0: unknown
};

/// A proportional law for a member of stiffness `member_stiffness`, held by an impedance of stiffness K and
/// damping D [N/m, N s/m]:
///
///   damping       critical for 1.4 kg on the member, limited to 120 N s/m by the noise of
///                 velocities from encoders
///   gain          a crossover of 30 rad/s, far below the limit for a delay of 5 ms
///   proportional  its zero cancels the pole of damping and member
///
/// @throws InvalidInput  a stiffness that is not above zero.
ForceLaw tuned_force_law(double member_stiffness, double follower_stiffness, double follower_damping);

/// One force in an object, between two of the arms that hold it.
struct CooperativeMember {
  int from = 0, to = 1;  ///< arms, from 0
  ForceLaw law;
  /// Share of x_f that each end takes if both are followers: 1/2 for position loops, which share a length; 1
  /// for impedances, which turn it into a force that is equal at both ends.
  double share = 1.0;
};

/// Reading of a member's force.
struct ForceReading {
  double force = 0.0;  ///< [N], positive in tension, filtered if the channel has a filter
  double age = 0.0;    ///< [s]
  std::optional<long> number{};  ///< sequence number of the sample; nullopt: none yet
  /// [N] unfiltered, for the stuck-sensor check; not finite: equal to `force`.
  double raw = std::numeric_limits<double>::quiet_NaN();
};

/// Computes x_f of one member, sample by sample.
class ForceTracker {
 public:
  /// @throws InvalidInput  numbers that are not finite or are below zero.
  explicit ForceTracker(const ForceLaw& law);

  /// Restarts at the force [N] of the feed-forward term, without a correction.
  void reset() noexcept;

  /// @param wanted  h_d [N]. @param rate  measured dl/dt [m/s]. @param dt  [s] period of the loop. @returns
  ///   change of the distance between the ends [m]; the last one if a number is not finite.
  double update(double wanted, const ForceReading& reading, double rate, double dt) noexcept;

  /// Freezes x_f and continues the damping term alone: for use without a sensor while targets are held.
  double update_without_sensor(double wanted, double rate) noexcept;

  double value() const { return value_; }        ///< result of the last update() or update_without_sensor()
  double velocity() const { return velocity_; }  ///< [m/s] derivative of x_f
  const ForceLaw& law() const { return law_; }

 private:
  /// Sum of the law's terms within its reach; `proportional` in [m].
  double limited(double wanted, double rate, double proportional) noexcept;

  ForceLaw law_;
  double x_f_ = 0.0, value_ = 0.0, velocity_ = 0.0;
  double last_time_ = 0.0, clock_ = 0.0;
  std::optional<long> number_;
};

}  // namespace veridyn
