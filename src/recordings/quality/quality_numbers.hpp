#pragma once

#include "recordings/absurd.hpp"
#include "veridyn/recordings/recording_quality.hpp"

namespace veridyn {

/// All numbers that can change findings about the quality of a recording. Each comment gives the condition,
/// then its consequence, and the reason where one is known.
struct QualityNumbers {
  // Rows and quantiles.
  /// number of rows >= fewest_rows, else motion and velocities are not checked.
  int fewest_rows = 50;
  /// the quantiles `ends` and 1 - ends of the values stand for the ends of their range: single wrong values do
  /// not count.
  double ends = 0.01;
  /// the quantile 1 - rare of the values is the largest usual value.
  double rare = 0.1;

  // Numbers, time, rows.
  /// |number| > absurd: the number is damaged.
  double absurd = kAbsurd;
  /// share of rows with such numbers >= hopeless_share: motion and velocities of the file are not checked.
  double hopeless_share = 0.002;
  /// range of a position <= resting_range [rad, m]: the joint is at rest.
  double resting_range = 5e-3;
  /// step of time > hole median steps: rows are missing.
  double hole = 1.5;
  /// share of missing rows > many_missing, or a hole > long_hole median steps: the finding is a warning, else a
  /// remark.
  double many_missing = 0.01, long_hole = 10.0;
  /// range of the time steps > irregular * their median: the sampling is irregular.
  double irregular = 0.05;
  /// |mean rate * median step - 1| > misleading: the time cannot be replaced by a fixed sampling rate.
  double misleading = 0.01;
  /// share of stale rows >= few_stale: reported; > many_stale: a warning; > frozen: a fault.
  double few_stale = 0.001, many_stale = 0.02, frozen = 0.5;
  /// share of missing values of a signal > few_gaps: the finding is a warning; > many_gaps: a fault.
  double few_gaps = 0.001, many_gaps = 0.5;
  /// number of signals with gaps > many_signals: one finding on the worst one replaces those of all signals.
  int many_signals = 3;
  /// |q| > two turns in a share of the rows >= beyond_turns: positions are in degrees or millimetres.
  double beyond_turns = 0.5;

  // Signals refreshed too slowly.
  /// change of a signal over three rows > fine * its resolution: it moves, so that equal values are no
  /// coincidence.
  double fine = 8.0;
  /// number of such rows >= fewest_fine, else the share of repeats is not determined.
  int fewest_fine = 200;
  /// share of repeats among them >= repeating: the signal is refreshed more slowly than it is recorded.
  double repeating = 0.1;

  // Overflow of a register.
  /// number of steps of a torque > overflow * its range, while its joint moves on, >= fewest_overflows: it
  /// overflows.
  double overflow = 0.8;
  int fewest_overflows = 3;

  // Start-up.
  /// `ringing` of a load: its usual change over `ringing` [s], in windows of `window` [s] and at least
  /// shortest_window rows.
  double ringing = 0.02, window = 0.1;
  int shortest_window = 4;
  /// ringing of a window > loud * the largest usual one of later windows: the window belongs to a transient.
  double loud = 3.0;
  /// number of the last such window among the first latest_start >= shortest_start: the transient is reported.
  int latest_start = 20, shortest_start = 2;

  // Jumps of positions.
  /// Largest step that noise explains: the largest of smallest_jump [rad, m], jump_noise * a large second
  /// difference, and jump_range * range.
  double smallest_jump = 2e-3, jump_noise = 5.0, jump_range = 0.02;
  /// step > this largest step + jump_around * the neighbouring steps: a jump, which the motion does not
  /// explain.
  double jump_around = 4.0;
  /// number of jumps of several joints >= fewest_lost, a share > `onward` of them along the motion: rows were
  /// lost.
  long fewest_lost = 3;
  double onward = 0.9;
  /// |jump - whole turns| < turn_error turns: the angle is wrapped.
  double turn_error = 0.02;

  // Scale of velocities.
  /// time step > gap median steps: no window contains it.
  double gap = 5.0;
  /// motion in a window > fast * the quantile 1 - fastest of all windows, else the window is excluded as noise.
  double fast = 0.3, fastest = 0.02;
  /// number of windows that remain >= fewest_windows, else no factor is determined.
  int fewest_windows = 50;
  /// |ratio of a window - median| > outlying * spread of the ratios: the window is excluded from the factor.
  double outlying = 6.0;
  /// spread of the ratios < agree * |factor|: the factor is reliable.
  double agree = 0.2;
  /// |correlation of both over the windows with motion| < related: dq is no derivative of this q.
  double related = 0.9;
  /// |factor - 1| > scale_error: reported; for a recording with one moving joint > clock_error, since its
  /// sensor may be wrong.
  double scale_error = 0.025, clock_error = 0.1;
  /// |factor + 1| < sign_error: the velocity has the opposite sign.
  double sign_error = 0.1;
  /// |factor / u - 1| < degree_error: velocities or positions are in another unit, with u = 180 / pi for
  /// degrees.
  double degree_error = 0.03;
  /// |factor - 1| > far_off: the finding is a fault, else a warning.
  double far_off = 0.3;
  /// range of the factors over the joints < one_clock * their median: they have one cause, such as the clock.
  double one_clock = 0.03;

  // Delay of velocities.
  /// a velocity is the mean over half_average rows on either side.
  int half_average = 4;
  /// step of a position > large_step * the quantile 1 - ends of its steps: no mean contains this row.
  double large_step = 3.0;
  /// delays of up to longest_lag rows are tested, in recordings of >= 6 longest_lag rows.
  int longest_lag = 40;
  /// correlation at its peak >= clear_peak, else no delay is reported.
  double clear_peak = 0.9;
  /// error of a row <= lag_outlier * the median error, else the row is excluded from the second pass.
  double lag_outlier = 4.0;
  /// |delay| >= delay_rows median time steps: the delay is reported.
  double delay_rows = 0.6;

  // Steps and noise of velocities.
  /// number of changes that are not zero >= fewest_changes, else quantisation is not checked.
  int fewest_changes = 20;
  /// smallest change > coarse * range: a torque is quantised; > grid_share * coarse * range: a velocity is.
  double coarse = 0.07, grid_share = 0.3;
  /// usual largest change > coarse * range and > two_kinds * the median change: a velocity jumps between
  /// levels, as those of an MTM and a PSM's wrist do; the ratio is 2.4 for Gaussian noise.
  double two_kinds = 3.5;
  /// noise of a velocity < noisier * that of the position's derivative: it is not reported.
  double noisier = 2.0;
  /// noise of a velocity < no_noise * its range: it is not reported either.
  double no_noise = 1e-4;

  // Saturation.
  /// difference of two values <= step_share * resolution: they count as equal.
  double step_share = 0.6;
  /// number of rows at the extreme >= shortest_run, entered and left by > abrupt tolerances: the signal is
  /// clipped.
  int shortest_run = 3;
  double abrupt = 5.0;
  /// share of clipped rows > many_clipped: the finding is a fault, else a warning.
  double many_clipped = 0.01;
  /// load > near_largest * its largest value in >= shortest_plateau successive rows: the rows form a plateau.
  double near_largest = 0.92;
  int shortest_plateau = 8;
  /// share of the plateau's scatter that a parabola explains > curved: the top of a wave (0.32 and 0.61 at the limits of a PSM,
  /// 0.98 and more on waves).
  double curved = 0.9;
  /// change of speed during a plateau > speed_change * the largest speed: the load is saturated, unlike on
  /// plateaus of friction. Speeds are measured over a share 1 / plateau_parts of the plateau.
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
/// |torque| or |current| < kNoLoad [N m, A] in every row: the load was not recorded.
constexpr double kNoLoad = 1e-8;
/// duration without an identification's cuts < kLeastSeconds [s]: a fault; kEnoughSeconds is the advised one.
constexpr double kLeastSeconds = 1.0, kEnoughSeconds = 10.0;
/// median time step >= kSlowClock [s] in a single motion: the times are in another unit.
constexpr double kSlowClock = 0.5;
/// share of gaps that follow one of equal length > kAlike: the recording has a second sample rate, and no rows
/// are missing.
constexpr double kAlike = 0.9;
/// a turn = kTurn [rad].
constexpr double kTurn = 6.283185307179586;
/// degrees = kDegrees * radians.
constexpr double kDegrees = 57.29577951308232;
/// velocity in turns a minute = kMinute * derivative of turns = kTurnsAMinute * derivative of radians.
constexpr double kMinute = 60.0, kTurnsAMinute = 9.549296585513721;
/// half the distance between the quantiles kQuartile and 1 - kQuartile is the spread of the ratios.
constexpr double kQuartile = 0.25;
/// square of the second difference of white noise = kSecondDifference * its variance.
constexpr double kSecondDifference = 6.0;
/// ratios that differ by <= kTinyRatio count as equal; |factor| <= kTinyFactor counts as zero.
constexpr double kTinyRatio = 1e-9, kTinyFactor = 1e-6;
/// determinant > kSingular * product of the squares, else the motion is too uniform for a delay.
constexpr double kSingular = 1e-12;
/// difference of two loads <= kExact * range: the loads count as equal.
constexpr double kExact = 1e-6;
/// share >= kWhole: the text has 100 %.
constexpr double kWhole = 0.995;
/// kPlainFrom <= |number| < kPlainTo: the text has no exponent and no digits after the point.
constexpr double kPlainFrom = 1000.0, kPlainTo = 1e6;

}  // namespace quality
}  // namespace veridyn
