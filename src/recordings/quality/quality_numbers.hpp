#pragma once

#include "recordings/absurd.hpp"
#include "veridyn/recordings/recording_quality.hpp"

namespace veridyn {

/// All numbers that can change findings about the quality of a recording, each with its inequality,
/// and with its reason where one is known.
struct QualityNumbers {
  // What is read.
  /// rows >= fewest_rows, else motion and velocities are not checked.
  int fewest_rows = 50;
  /// Quantiles = ends and 1 - ends stand for the ends of a range: single wrong values do not count.
  double ends = 0.01;
  /// Quantile = 1 - rare is the largest usual value.
  double rare = 0.1;

  // Numbers, time, rows.
  /// |number| > absurd: damaged.
  double absurd = kAbsurd;
  /// share of rows with such numbers >= hopeless_share: the motion of the file is not judged.
  double hopeless_share = 0.002;
  /// range of a position <= resting_range [rad, m]: the joint is at rest.
  double resting_range = 5e-3;
  /// step of time > hole median steps: rows are missing.
  double hole = 1.5;
  /// share of missing rows > many_missing, or a hole > long_hole median steps: a warning, else a remark.
  double many_missing = 0.01, long_hole = 10.0;
  /// spread of the steps > irregular * their median: irregular.
  double irregular = 0.05;
  /// |mean rate * median step - 1| > misleading: a fixed rate would be wrong.
  double misleading = 0.01;
  /// share of stale rows >= few_stale: reported; > many_stale: a warning; > frozen: a fault.
  double few_stale = 0.001, many_stale = 0.02, frozen = 0.5;
  /// share of missing values > few_gaps: a warning; > many_gaps: a fault.
  double few_gaps = 0.001, many_gaps = 0.5;
  /// signals with gaps > many_signals: one finding for the file.
  int many_signals = 3;
  /// |q| > two turns in a share of the rows >= beyond_turns: degrees, or millimetres.
  double beyond_turns = 0.5;

  // Signals refreshed too slowly.
  /// change over three rows > fine * resolution: equal values are no coincidence.
  double fine = 8.0;
  /// such rows >= fewest_fine, else nothing is reported.
  int fewest_fine = 200;
  /// share of repeats >= repeating: refreshed too slowly.
  double repeating = 0.1;

  // Overflow of a register.
  /// steps of a torque > overflow * its range while its joint moves on, >= fewest_overflows of them: it overflows.
  double overflow = 0.8;
  int fewest_overflows = 3;

  // Start-up.
  /// ringing = usual change over `ringing` [s] in windows of `window` = [s] and shortest_window rows.
  double ringing = 0.02, window = 0.1;
  int shortest_window = 4;
  /// ringing > loud * the usual one of later windows ...
  double loud = 3.0;
  /// ... in >= shortest_start windows among the first latest_start: a transient of the start.
  int latest_start = 20, shortest_start = 2;

  // Jumps of positions.
  /// step > smallest_jump [rad, m], jump_noise * the largest second difference, jump_range * range ...
  double smallest_jump = 2e-3, jump_noise = 5.0, jump_range = 0.02;
  /// ... and > jump_around * the steps around it beyond that: motion does not explain it.
  double jump_around = 4.0;
  /// jumps of several joints >= fewest_lost, more than `onward` of them in the direction of the motion: rows were lost.
  long fewest_lost = 3;
  double onward = 0.9;
  /// |jump| < turn_error turns from a whole number of them: the angle is wrapped.
  double turn_error = 0.02;

  // Scale of velocities.
  /// step of time > gap median steps: no window spans it.
  double gap = 5.0;
  /// motion of a window > fast * its quantile 1 - fastest: slow windows are noise.
  double fast = 0.3, fastest = 0.02;
  /// such windows >= fewest_windows, else nothing is reported.
  int fewest_windows = 50;
  /// |ratio - median| > outlying * spread: the window does not count.
  double outlying = 6.0;
  /// spread < agree * |factor|: the factor is clear.
  double agree = 0.2;
  /// |correlation of both over the windows with motion| < related: dq is no derivative of this q.
  double related = 0.9;
  /// |factor - 1| > scale_error: reported; clock_error on a single joint, whose own sensor may be off.
  double scale_error = 0.025, clock_error = 0.1;
  /// |factor + 1| < sign_error: the opposite sign.
  double sign_error = 0.1;
  /// |factor * 180 / pi - 1| < degree_error, or / : degrees.
  double degree_error = 0.03;
  /// |factor - 1| > far_off: a fault, else a warning.
  double far_off = 0.3;
  /// spread of the factors < one_clock * their median: one clock is off.
  double one_clock = 0.03;

  // Delay of velocities.
  /// half of the rows that are averaged = half_average.
  int half_average = 4;
  /// step > large_step * the largest one: a wrong row.
  double large_step = 3.0;
  /// |delay| < longest_lag rows, rows >= 6 longest_lag.
  int longest_lag = 40;
  /// correlation at its peak >= clear_peak, else there is no delay to speak of.
  double clear_peak = 0.9;
  /// error <= lag_outlier medians counts in the second pass.
  double lag_outlier = 4.0;
  /// |delay| >= delay_rows median steps: reported.
  double delay_rows = 0.6;

  // Steps and noise of velocities.
  /// changes that are not zero >= fewest_changes, else nothing is reported.
  int fewest_changes = 20;
  /// step > coarse * range: quantised; grid_share of it, if all steps are multiples of one.
  double coarse = 0.07, grid_share = 0.3;
  /// usual step > two_kinds * median: jumps between levels, as velocities of an MTM and a PSM's wrist have;
  /// 2.4 for Gaussian noise.
  double two_kinds = 3.5;
  /// noise > noisier * that of the position's derivative ...
  double noisier = 2.0;
  /// ... and > no_noise * range: reported.
  double no_noise = 1e-4;

  // Saturation.
  /// difference of two values <= step_share * resolution: equal.
  double step_share = 0.6;
  /// rows at the extreme >= shortest_run, entered and left by > abrupt tolerances: clipped.
  int shortest_run = 3;
  double abrupt = 5.0;
  /// share of clipped rows > many_clipped: a fault, else a warning.
  double many_clipped = 0.01;
  /// load > near_largest * the largest, for shortest_plateau rows and more: a plateau ...
  double near_largest = 0.92;
  int shortest_plateau = 8;
  /// ... of whose scatter a parabola explains <= curved (0.32 and 0.61 at the limits of a PSM, 0.98 and more on tops of waves) ...
  double curved = 0.9;
  /// ... and speed changes by > speed_change of the largest meanwhile, unlike on plateaus of friction, over
  /// a length / plateau_parts at either end.
  double speed_change = 0.25;
  int plateau_parts = 4;
};

/// Numbers that change no finding: memory, units, facts of statistics, rounding, and how numbers are printed.
namespace quality {

constexpr QualityNumbers numbers;

/// rows that scales and checks of motion see <= kHeadRows: 1000 s at 200 Hz; those of delays <= kLagRows.
constexpr int kHeadRows = 200000, kLagRows = 60000;
/// rows in memory at once <= kPieceRows + kContext: files may be larger than memory.
constexpr int kPieceRows = 50000;
/// rows of the piece before = kContext: rows before a piece that checks of jumps and motion use.
constexpr int kContext = 6;
/// |torque| or |current| < kNoLoad [N m, A] in every row: it was not recorded.
constexpr double kNoLoad = 1e-8;
/// seconds that an identification does not cut < kLeastSeconds: a fault; kEnoughSeconds = what is advised.
constexpr double kLeastSeconds = 1.0, kEnoughSeconds = 10.0;
/// median step >= kSlowClock [s] in one motion: times in another unit.
constexpr double kSlowClock = 0.5;
/// gaps that follow one of equal length > kAlike * all gaps: a second sample rate, and no rows are missing.
constexpr double kAlike = 0.9;
/// a turn = kTurn [rad].
constexpr double kTurn = 6.283185307179586;
/// degrees = kDegrees * radians.
constexpr double kDegrees = 57.29577951308232;
/// velocity in turns a minute = kMinute * derivative of turns = kTurnsAMinute * derivative of radians.
constexpr double kMinute = 60.0, kTurnsAMinute = 9.549296585513721;
/// half the distance of the quantiles = kQuartile and 1 - kQuartile is the spread of ratios.
constexpr double kQuartile = 0.25;
/// square of the second difference of white noise = kSecondDifference * its variance.
constexpr double kSecondDifference = 6.0;
/// ratios that differ by <= kTinyRatio are equal; |factor| > kTinyFactor, or there is none.
constexpr double kTinyRatio = 1e-9, kTinyFactor = 1e-6;
/// determinant > kSingular * product of the squares, else the motion is too uniform.
constexpr double kSingular = 1e-12;
/// difference of two loads <= kExact * range: equal.
constexpr double kExact = 1e-6;
/// share >= kWhole: printed as 100 %.
constexpr double kWhole = 0.995;
/// kPlainFrom <= |number| < kPlainTo: printed without an exponent and digits behind the point.
constexpr double kPlainFrom = 1000.0, kPlainTo = 1e6;

}  // namespace quality
}  // namespace veridyn
