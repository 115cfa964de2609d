#pragma once

/// All numbers that can change what is said about the quality of a recording, each with its inequality,
/// and with its reason where one is known.
namespace veridyn::quality {

// What is read.
/// rows that scales and checks of motion see <= kHeadRows: 1000 s at 200 Hz.
constexpr int kHeadRows = 200000;
/// rows in memory at once <= kPieceRows + kContext: files may be larger than memory.
constexpr int kPieceRows = 50000;
/// rows of the piece before = kContext: jumps and motion look back so far.
constexpr int kContext = 6;
/// rows >= kFewestRows, else motion and velocities are not checked.
constexpr int kFewestRows = 50;
/// Quantiles = kLowest and kHighest stand for the ends of a range: single wrong values do not count.
constexpr double kLowest = 0.01, kHighest = 0.99;
/// half the distance of the quantiles kQuartile and 1 - kQuartile = the spread of ratios.
constexpr double kQuartile = 0.25;

// Numbers, time, rows.
/// |number| > kAbsurd: damaged; no joint reaches it in SI units.
constexpr double kAbsurd = 1e6;
/// share of rows with such numbers >= kHopelessShare: the motion of the file is not judged.
constexpr double kHopelessShare = 0.002;
/// range of a position <= kRestingRange [rad, m]: the joint is at rest.
constexpr double kRestingRange = 5e-3;
/// step of time > kHole median steps: rows are missing.
constexpr double kHole = 1.5;
/// share of missing rows > kManyMissing, or a hole > kLongHole median steps: a warning, else a remark.
constexpr double kManyMissing = 0.01, kLongHole = 10.0;
/// spread of the steps > kIrregular * their median: irregular.
constexpr double kIrregular = 0.05;
/// |mean rate * median step - 1| > kMisleading: a fixed rate would be wrong.
constexpr double kMisleading = 0.01;
/// share of stale rows >= kFewStale: reported; > kManyStale: a warning; > kFrozen: a fault.
constexpr double kFewStale = 0.001, kManyStale = 0.02, kFrozen = 0.5;
/// share of missing values > kFewGaps: a warning; > kManyGaps: a fault.
constexpr double kFewGaps = 0.001, kManyGaps = 0.5;
/// signals with gaps > kManySignals: one finding for the file.
constexpr long kManySignals = 3;
/// |q| > 2 kTurn in a share of the rows >= kBeyondTurns: degrees, or millimetres.
constexpr double kTurn = 6.283185307179586;
constexpr double kBeyondTurns = 0.5;

// Signals refreshed too slowly.
/// change over three rows > kFine * resolution: equal values are no coincidence.
constexpr double kFine = 8.0;
/// such rows >= kFewestFine, else nothing is said.
constexpr long kFewestFine = 200;
/// share of repeats after one row >= kRepeating ...
constexpr double kRepeating = 0.1;
/// ... and repeats after two rows <= kReturning * those after one: values that alternate are noise.
constexpr double kReturning = 0.7;

// Start-up.
/// ringing = rms change over kRinging [s] in windows of kWindow [s] and kShortestWindow rows.
constexpr double kRinging = 0.02, kWindow = 0.1;
constexpr int kShortestWindow = 4;
/// ringing > kLoud * the quantile kUsual of later windows ...
constexpr double kLoud = 3.0, kUsual = 0.9;
/// ... in >= kShortestStart windows among the first kLatestStart: a transient of the start.
constexpr int kLatestStart = 20, kShortestStart = 2;

// Jumps of positions.
/// second difference > kSmallestJump [rad, m], kJumpNoise * its quantile kHighest, kJumpRange * range ...
constexpr double kSmallestJump = 2e-3, kJumpNoise = 5.0, kJumpRange = 0.02;
/// ... and > kJumpAround * the steps around it beyond that: motion does not explain it.
constexpr double kJumpAround = 4.0;
/// |jump| > kNearlyTurn turns and < kTurnError from a whole number of them: the angle is wrapped.
constexpr double kNearlyTurn = 0.9, kTurnError = 0.02;

// Scale of velocities.
/// degrees = kDegrees * radians.
constexpr double kDegrees = 57.29577951308232;
/// step of time > kGap median steps: no window spans it.
constexpr double kGap = 5.0;
/// motion of a window > kFast * its quantile kFastest: slow windows are noise.
constexpr double kFast = 0.3, kFastest = 0.98;
/// such windows >= kFewestWindows, else nothing is said.
constexpr int kFewestWindows = 50;
/// |ratio - median| > kOutlying * spread + kTinyRatio: the window does not count.
constexpr double kOutlying = 6.0, kTinyRatio = 1e-9;
/// spread < kAgree * |factor| and |factor| > kTinyFactor: the factor is clear.
constexpr double kAgree = 0.2, kTinyFactor = 1e-6;
/// |factor - 1| > kScaleError: reported; kClockError on a single joint, whose own sensor may be off.
constexpr double kScaleError = 0.025, kClockError = 0.1;
/// |factor + 1| < kSignError: the opposite sign.
constexpr double kSignError = 0.1;
/// |factor * 180 / pi - 1| < kDegreeError, or / : degrees.
constexpr double kDegreeError = 0.05;
/// |factor - 1| > kFarOff: a fault, else a warning.
constexpr double kFarOff = 0.3;
/// spread of the factors < kOneClock * their median: one clock is off.
constexpr double kOneClock = 0.03;

// Delay of velocities.
/// rows that are compared <= kLagRows.
constexpr int kLagRows = 60000;
/// half of the rows that are averaged = kHalfAverage.
constexpr int kHalfAverage = 4;
/// step > kLargeStep * its quantile kHighest: a wrong row.
constexpr double kLargeStep = 3.0;
/// |delay| < kLongestLag rows, rows >= 4 kLongestLag.
constexpr int kLongestLag = 40;
/// correlation at its peak >= kClearPeak, else there is no delay to speak of.
constexpr double kClearPeak = 0.9;
/// rows at either end > kLagMargin: the averages and the lag fit inside.
constexpr int kLagMargin = 50;
/// error <= kLagOutlier medians counts in the second pass.
constexpr double kLagOutlier = 4.0;
/// determinant > kSingular * product of the squares, else the motion is too uniform.
constexpr double kSingular = 1e-12;
/// |delay| >= kShortestDelay [s] and kDelayRows median steps: reported.
constexpr double kShortestDelay = 0.002, kDelayRows = 0.6;

// Steps and noise of velocities.
/// changes that are not zero >= kFewestChanges, else nothing is said.
constexpr int kFewestChanges = 20;
/// step > kCoarse * range: quantised; kGridShare of it, if all steps are multiples of one.
constexpr double kCoarse = 0.07, kGridShare = 0.3;
/// quantile kUsual of the steps > kTwoKinds * median: jumps between levels; 2.4 for Gaussian noise.
constexpr double kTwoKinds = 3.5;
/// noise > kNoisier * that of the position's derivative ...
constexpr double kNoisier = 2.0;
/// ... and > kNoNoise * range: reported; rows next to a stale one within kNoiseReach do not count.
constexpr double kNoNoise = 1e-4;
constexpr int kNoiseReach = 2;
/// square of the second difference of white noise = kSecondDifference * its variance.
constexpr double kSecondDifference = 6.0;

// Saturation.
/// difference of two values <= min(kStepShare * resolution, kFlat * range), or <= kExact * range: equal.
constexpr double kStepShare = 0.6, kFlat = 1e-3, kExact = 1e-6;
/// rows at the extreme >= kShortestRun, entered and left by > kAbrupt tolerances: clipped.
constexpr long kShortestRun = 3;
constexpr double kAbrupt = 5.0;
/// share of clipped rows > kManyClipped: a fault, else a warning.
constexpr double kManyClipped = 0.01;
/// load > kNearLargest * the largest, for kShortestPlateau rows and more: a plateau ...
constexpr double kNearLargest = 0.92;
constexpr int kShortestPlateau = 8;
/// ... and speed changes by > kSpeedChange of the largest meanwhile, unlike on plateaus of friction, over
/// a length / kPlateauParts at either end.
constexpr double kSpeedChange = 0.25;
constexpr int kPlateauParts = 4;

// Words.
/// share >= kWhole: printed as 100 %.
constexpr double kWhole = 0.995;
/// kPlainFrom <= |number| < kPlainTo: printed without an exponent and digits behind the point.
constexpr double kPlainFrom = 1000.0, kPlainTo = 1e6;

}  // namespace veridyn::quality
