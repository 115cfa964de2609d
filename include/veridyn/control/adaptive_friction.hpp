#pragma once

#include <vector>

#include "veridyn/control/friction_compensation.hpp"

namespace veridyn {

struct AdaptiveFrictionOptions {
  bool enabled = false;  ///< off unless asked for
  double rate = 0.05;    ///< [1/s] of motion
  double least = 0.5;    ///< Lower bound, as a share of the identified friction
  double most = 1.5;
  Deadband velocity{0.02, 0.01};  ///< below which nothing is learned
};

/// Slow online update of friction (an outlook of the thesis, chapter 8): grease ages and warms. In
/// motion, the torque that the model lacks along an axis is explained by an offset, which is
/// forgotten again, and by the direction of motion, which scales the axis' friction:
///
///   lacking = offset + (s* - s) F(direction) direction
///
/// by normalised gradient steps, between physical bounds. The offset keeps errors of gravity out of
/// it as long as the axis moves both ways.
///
///   AdaptiveFriction adaptive(friction, options);   // options.enabled = true
///   every cycle: adaptive.update(state, error.torque(), 0.001, friction);
class AdaptiveFriction {
 public:
  /// @throws InvalidInput  bounds that do not hold 1 between them, a rate below zero.
  explicit AdaptiveFriction(const FrictionCompensation& friction,
                            const AdaptiveFrictionOptions& options = {});

  /// @param lacking  (n) torque that is lacking beside the compensation by `friction`:
  ///                 ModelErrorObserver::torque(), where nothing touches the arm. @param dt [s].
  /// Sizes are those of the constructor; another one is a fault of the program, asserted in debug
  /// builds alone.
  void update(const ArmState& arm, const VectorXd& lacking, double dt,
              FrictionCompensation& friction) noexcept;

  double scale(int axis) const { return scale_[static_cast<size_t>(axis)]; }

 private:
  AdaptiveFrictionOptions options_;
  std::vector<double> scale_, offset_;
};

}  // namespace veridyn
