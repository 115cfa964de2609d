#pragma once

#include <vector>

namespace veridyn {

/// All numbers that can change the events of `watch`, each with its inequality, and with its reason
/// where one is known. Those that a user sets are in WatchOptions.
struct WatchNumbers {
  // Rows and their smoothing.
  /// half window of the smoothing [s] = half_window: motions of 5 Hz and slower pass.
  double half_window = 0.05;
  /// the same where velocities are derived, twice, = half_window_of_position [s].
  double half_window_of_position = 0.08;
  /// rows >= rows_for_step: the time step is the median of the first ones.
  int rows_for_step = 30;
  /// time without a row > pause [s]: filters begin anew. Times that fell and rise again for half of it: the clock
  /// was set back.
  double pause = 0.5;
  /// torques of all joints <= no_torque * their rms: no drive is on.
  double no_torque = 0.02;
  /// a signal stays the same for <= held [s]: its next value is awaited, and it is interpolated; longer means rest.
  double held = 0.1;

  // Jumps of a position.
  /// samples within jump_reach [s] of a jump <= those of its statistic. Times that rise for as long before they
  /// have caught up with a clock that was set back: a break, and no jump.
  double jump_reach = 0.02;
  /// jump > jump_over_largest * the largest one of the quiet arm, ...
  double jump_over_largest = 2.5;
  /// ... jump > jump_of_way * displacement of the joint, so that a fast motion is no jump, ...
  double jump_of_way = 0.3;
  /// ... jump > smallest_jump_turning [rad], smallest_jump_sliding [m]: less is within the play of a joint.
  double smallest_jump_turning = 5e-4, smallest_jump_sliding = 1e-4;

  // A clock that goes wrong.
  /// velocities by the derivative of the positions, over clock_memory [s], differ from one by > clock_error on all joints
  /// together, and also without any one of them: the clock is wrong, or another unit.
  double clock_memory = 0.2, clock_error = 0.1;

  // Noise of the quiet arm.
  /// steps >= steps_for_pole * kOrder, else the noise counts as white.
  int steps_for_pole = 4;
  /// deviation of the day's difference of damping from the model = rms torque at a speed slow [rad/s], [m/s]
  /// that every joint reaches; of other differences, rms torque (a prior).
  double slow = 0.1;
  /// deviation of the innovations >= least_share of the rms torque: models are not better than that.
  double least_share = 2e-3;
  /// |pole| <= largest_pole: a quiet beginning is too short to estimate larger ones.
  double largest_pole = 0.98;
  /// part of a motion > beyond * the largest learned: it is unseen.
  double beyond = 1.1;
  /// |ds| < rest_share * the largest speed: dry friction is undetermined, and a joint does not move.
  double rest_share = 0.03;

  // When something has changed.
  /// memories of the statistics [s] = short_memory, middle_memory, long_memory: short for pushes, long for small
  /// changes. A push counts as constant over the short one; a quiet recording > the middle one, else the
  /// dispersion is not known.
  double short_memory = 0.5, middle_memory = 2.0, long_memory = 8.0;
  /// windows that the prior dispersion is worth = prior_freedom, with the dispersion prior_dispersion: a
  /// quiet beginning has few windows of its own.
  double prior_freedom = 8.0;
  double prior_dispersion = 3.0;
  /// consecutive steps beyond the threshold >= above_in_a_row: an alarm.
  int above_in_a_row = 2;
  /// time after an event < refractory_time [s]: no alarm, memories fill again.
  double refractory_time = 1.0;
  /// unseen motion >= unseen_motion [s]: learning resumes.
  double unseen_motion = 1.0;
  /// steps of the day that are kept <= most_quiet: two minutes.
  int most_quiet = 1200;

  // What it is.
  /// steps that are kept to isolate a cause <= recent [s].
  double recent = 20.0;
  /// gain of the best cause - gain of another < odds * dispersion: they are rivals; twice the logarithm of odds
  /// of 100 to 1.
  double odds = 9.2;
  /// time since the onset >= soonest_name [s]: it is named, because a push may still end.
  double soonest_name = 2.0;
  /// squares of the innovations that a cause leaves, above those of the noise, < unexplained of those before it: it is
  /// named, else it is a push or not on the list.
  double unexplained = 0.05;
  /// time without a push > push_ends [s]: it is over.
  double push_ends = 0.8;
  /// a push >= shortest_push [s].
  double shortest_push = 0.2;
  /// share of the gain that a joint brings > active: the push is named on it.
  double active = 0.1;
  /// innovations > mixed steps after the onset: those before mix both states.
  double mixed = 2.5;
  /// friction <= largest_torques * rms torque of the joint: none grows beyond it.
  double largest_torques = 3.0;
  /// centre of a load = lever [m] off its frame (a prior): without it Watch.ACauseIsNamedAtAnyOnset takes an offset
  /// for a load.
  double lever = 0.1;
  /// relative systematic error of a size = systematic: smoothing, first-order columns.
  double systematic = 0.02;
  /// gain > present_odds * odds of a change that was there in the beginning: all hypotheses are compared ...
  double present_odds = 3.0;
  /// ... its torque >= present_share of the joint's rms torque: less differs from day to day; and it leaves
  /// <= present_share of the squares that the model leaves.
  double present_share = 0.1;
};

namespace watching {

/// times are equal within kSameTime = a millionth of a step.
constexpr double kSameTime = 1e-6;
/// first rows <= kStart pauses: from them follow the time step, and how often signals are refreshed.
constexpr double kStart = 4.0;
/// half the smoothing's window >= kHalfWindow new values of each position and velocity.
constexpr double kHalfWindow = 3.0;
/// order of the autoregressions = kOrder, for the residuals of smoothing and friction.
constexpr int kOrder = 2;
/// time since the last learned step < kFollows steps: the step follows without a gap; times are multiples of the step.
constexpr double kFollows = 1.5;
/// time since a jump of a position >= kAgain * jump_reach without another one: it is reported. One within a pause: a wrong
/// velocity, and no jump.
constexpr double kAgain = 5.0;
/// probability outside of an interval = kOutside.
constexpr double kOutside = 0.05;
/// information of a column > kNothing, else it is not there.
constexpr double kNothing = 1e-12;

}  // namespace watching
}  // namespace veridyn
