#pragma once

#include <limits>

namespace veridyn {

/// How the length of a member is corrected for the force in it: x_f of thesis 7.7.2, [m] by which
/// its ends are asked to be farther apart. With e = h_d - h_e, too little tension makes x_f grow.
struct ForceLaw {
  enum class Kind {
    kIncrement,    ///< 7.7.3: x_f moves by `increment` in the sign of e wherever |e| > deadband
    kProportional  ///< (7.12): x_f += gain * e, with what the thesis lacked below
  };
  Kind kind = Kind::kProportional;
  double deadband = 0.0;   ///< [N] within which x_f rests
  double increment = 0.0;  ///< [m] per sample of the sensor
  double gain = 0.0;       ///< K_f [m/(N s)]: per second, so that the sensor's rate does not matter
  double proportional = 0.0;  ///< [m/N] beside the integral that (7.12) is
  /// [s] The damping that the thesis lacked: the ends give way against the rate at which the member
  /// is measured to lengthen, x_f - damping * dl/dt. With a follower of stiffness K it damps the
  /// member by K * damping.
  double damping = 0.0;
  double feed_forward = 0.0;  ///< [m/N] times h_d: 1 / K of an impedance follower
  double reach = 0.05;        ///< [m] largest |x_f|
  double stiffness = 0.0;  ///< [N/m] of the member as far as known, for the watch over the sensor
};

/// A proportional law for a member of that stiffness, held by an impedance of stiffness K and
/// damping D [N/m, N s/m]:
///
///   damping       critical for 1.4 kg on the member, up to 120 N s/m, which velocities from
///                 encoders bear
///   gain          a crossover of 30 rad/s, far below what 5 ms of delay allow
///   proportional  its zero lies on the pole that damping and member make
///
/// @throws InvalidInput  a stiffness that is not above zero.
ForceLaw tuned_force_law(double member_stiffness, double follower_stiffness, double follower_damping);

/// One force in an object, between two of the arms that hold it.
struct CooperativeMember {
  int from = 0, to = 1;  ///< arms, from 0
  ForceLaw law;
  /// Of x_f for each end where both are followers: 1/2 for position loops, which share a length; 1 for
  /// impedances, which make forces of it, and the force is the same at both ends.
  double share = 1.0;
};

/// What a controller knows of a member's force.
struct ForceReading {
  double force = 0.0;  ///< [N], pulling positive, filtered where it is
  double age = 0.0;    ///< [s]
  long number = -1;    ///< Number of the sample; -1: none yet
  /// [N] as the sensor gave it, for the watch over stuck sensors; not finite: as `force`.
  double raw = std::numeric_limits<double>::quiet_NaN();
};

/// x_f of one member, sample by sample.
class ForceTracker {
 public:
  /// @throws InvalidInput  numbers that are not finite or below zero.
  explicit ForceTracker(const ForceLaw& law);

  /// Starts over at a force [N] that the feed-forward gives, without a correction.
  void reset() noexcept;

  /// @param wanted  h_d [N]. @param rate  dl/dt as measured [m/s]. @param dt  [s] of the loop.
  /// @returns what is to be added to the distance of the ends [m].
  double update(double wanted, const ForceReading& reading, double rate, double dt) noexcept;

  /// For what holds, without a sensor: x_f stands, the damping goes on.
  double hold(double wanted, double rate) noexcept;

  double value() const { return value_; }        ///< Value of the last update() or hold()
  double velocity() const { return velocity_; }  ///< [m/s] of x_f
  const ForceLaw& law() const { return law_; }

 private:
  ForceLaw law_;
  double x_f_ = 0.0, value_ = 0.0, velocity_ = 0.0;
  double last_time_ = 0.0, clock_ = 0.0;
  long number_ = -1;
};

}  // namespace veridyn
