#pragma once

#include <vector>

#include "veridyn/control/friction_compensation.hpp"

namespace veridyn {

struct AdaptiveFrictionOptions {
  bool enabled = false;  ///< off by default
  double rate = 0.05;    ///< [1/s] of motion
  double least = 0.5;    ///< lower bound, as a share of the identified friction
  double most = 1.5;
  Deadband velocity{0.02, 0.01};  ///< below which nothing is learned
};

/// Slow online update of friction (an outlook of the thesis, chapter 8): grease ages and warms.
/// While the axis moves, the torque that the model lacks along it is split into an offset, which
/// decays, and a part in the direction of motion, which scales the axis' friction:
///
///   lacking = offset + (s* - s) F(direction) direction
///
/// by normalised gradient steps within physical bounds. The offset absorbs errors of gravity as
/// long as the axis moves both ways.
///
///   AdaptiveFriction adaptive(friction, options);   // options.enabled = true
///   every cycle: adaptive.update(state, error.torque(), 0.001, friction);
class AdaptiveFriction {
 public:
  /// @throws InvalidInput  bounds that do not contain 1, or a rate below zero.
  explicit AdaptiveFriction(const FrictionCompensation& friction,
                            const AdaptiveFrictionOptions& options = {});

  /// @param lacking  (n) torque that is missing beyond the compensation by `friction`:
  /// ModelErrorObserver::torque(), while the arm touches nothing. @param dt [s].
  /// Vectors have the sizes of the constructor; debug builds assert it.
  void update(const ArmState& arm, const VectorXd& lacking, double dt,
              FrictionCompensation& friction) noexcept;

  double scale(int axis) const { return scale_[static_cast<size_t>(axis)]; }

 private:
  AdaptiveFrictionOptions options_;
  std::vector<double> scale_, offset_;
};

}  // namespace veridyn
