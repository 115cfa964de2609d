#pragma once

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Moves a point from its present position, velocity and acceleration to rest at a goal: each entry follows the
/// polynomial of degree five that meets all six conditions. A new goal during a move starts from the present state,
/// so that velocity and acceleration do not jump. Works for joint vectors and for task coordinates (Cartesian moves
/// along a straight line; the thesis moves 5 mm in 1 s with it). Nothing allocates after the constructor.
///
///   QuinticInterpolator way(x_start);
///   way.move_to(x_goal, 1.0);
///   every cycle: way.advance(0.001), then way.x(), way.dx(), way.ddx()
class QuinticInterpolator {
 public:
  /// Starts at rest at x. @throws InvalidInput  x has no entries or one that is not finite.
  explicit QuinticInterpolator(const VectorRef& x);

  /// Sets the point to x, at rest; no change if x has another size or an entry that is not finite.
  void reset(const VectorRef& x) noexcept;

  /// Moves to `goal`, to arrive at rest after `duration` [s]. False, without a change, if the goal has
  /// another size or an entry that is not finite, or if the duration is not above zero.
  bool move_to(const VectorRef& goal, double duration) noexcept;

  /// Stops within `duration` [s], at a goal that is velocity * duration / 2 ahead of the present position. False as move_to().
  bool stop(double duration) noexcept;

  /// Advances the time by dt [s] >= 0; the point rests at the goal once it is reached.
  void advance(double dt) noexcept;

  bool arrived() const { return time_ >= duration_; }
  const VectorXd& x() const { return x_; }
  const VectorXd& dx() const { return dx_; }
  const VectorXd& ddx() const { return ddx_; }
  const VectorXd& goal() const { return goal_; }

  /// Duration [s] of a move from rest over `distance` with bounded velocity and acceleration.
  static double duration_for(double distance, double velocity, double acceleration) noexcept;

 private:
  double time_ = 0.0, duration_ = 0.0;
  VectorXd x_, dx_, ddx_, goal_;
  MatrixXd c_;  // (n x 6), ascending powers of time
};

}  // namespace veridyn
