#pragma once

#include <cstddef>

/// All numbers that can change what `watch` says, each with its inequality, and with its reason
/// where one is known. Those that a user sets are in WatchOptions.
namespace veridyn::watching {

// Rows and their smoothing.
/// half window of the smoothing [s] = kHalfWindow: motions of 5 Hz and slower pass.
constexpr double kHalfWindow = 0.05;
/// the same where velocities are derived, twice, = kHalfWindowOfPosition [s].
constexpr double kHalfWindowOfPosition = 0.08;
/// rows >= kRowsForStep: the time step is their median.
constexpr int kRowsForStep = 30;
/// times are equal within kSameTime = a millionth of a step.
constexpr double kSameTime = 1e-6;
/// time without a row > kPause [s]: filters begin anew.
constexpr double kPause = 0.5;
/// |q|, |dq|, |tau| >= kAbsurd: the row is damaged.
constexpr double kAbsurd = 1e6;
/// repeats of a row < kRepeats: they are stale; more mean rest.
constexpr int kRepeats = 20;
/// seconds of the quiet beginning >= kJudged * learn: velocities are judged; the other half is learned with
/// them or without.
constexpr double kJudged = 0.5;
/// rows of a quiet recording > kFewestQuiet steps, two seconds of 0.1 s each.
constexpr std::size_t kFewestQuiet = 20;

// Jumps of a position.
/// samples within kJumpReach [s] of a jump <= those of its statistic.
constexpr double kJumpReach = 0.02;
/// jump > kJumpDeviations * its statistic's own scatter, ...
constexpr double kJumpDeviations = 12.0;
/// ... jump > kJumpOverLargest * the largest one of the quiet arm, ...
constexpr double kJumpOverLargest = 2.5;
/// ... jump > kJumpOfWay * displacement of the joint, so that a fast motion is no jump, ...
constexpr double kJumpOfWay = 0.3;
/// ... jump > kSmallestJump [rad], [m]: less is within the play of a joint.
constexpr double kSmallestJump[] = {5e-4, 1e-4};
/// weight of a later sample in the scatter >= kQuietLeak: it follows an arm that becomes rougher.
constexpr double kQuietLeak = 1e-4;

// Noise of the quiet arm.
/// order of the autoregressions = kOrder: what smoothing and friction leave.
constexpr int kOrder = 2;
/// steps >= kStepsForPole * kOrder, else the noise counts as white.
constexpr int kStepsForPole = 4;
/// deviation of the day's difference from the model = kDailyShare of a joint's rms torque (a prior).
constexpr double kDailyShare = 0.1;
/// the same of damping = kDailyShare of the rms torque at a speed kSlow [rad/s], [m/s] that every joint
/// reaches.
constexpr double kSlow = 0.1;
/// deviation of the innovations >= kLeastShare of the rms torque: models are not better than that.
constexpr double kLeastShare = 2e-3;
/// |pole| <= kLargestPole: a quiet beginning is too short to estimate larger ones.
constexpr double kLargestPole = 0.98;
/// error of the model outside the learned range = kUnlearned of the torque there.
constexpr double kUnlearned = 0.5;
/// part of a motion > kBeyond * the largest learned: it is unseen.
constexpr double kBeyond = 1.1;
/// alternations between the day's differences and the autoregression = kRounds (not measured).
constexpr int kRounds = 3;
/// |ds| < kRestShare * the largest speed: dry friction is undetermined.
constexpr double kRestShare = 0.03;

// When something has changed.
/// memories of the statistics [s] = kMemories: short for pushes, long for small changes.
constexpr double kMemories[] = {0.5, 2.0, 8.0};
/// time since the beginning >= min(length of a memory, kFilled * learn): it is asked.
constexpr double kFilled = 0.25;
/// windows that the prior dispersion is worth = kPriorFreedom, with the dispersion kPriorDispersion: a
/// quiet beginning has few windows of its own.
constexpr double kPriorFreedom = 8.0;
constexpr double kPriorDispersion = 3.0;
/// consecutive steps beyond the threshold >= kAboveInARow: an alarm.
constexpr int kAboveInARow = 2;
/// time after an event < kRefractoryTime [s]: no alarm, memories fill again.
constexpr double kRefractoryTime = 1.0;
/// strength < kQuietLevel: the time is quiet, and learned from.
constexpr double kQuietLevel = 0.5;
/// unseen motion >= kUnseenMotion [s]: learning resumes.
constexpr double kUnseenMotion = 1.0;
/// steps of the day that are kept <= kMostQuiet: two minutes.
constexpr std::size_t kMostQuiet = 1200;
/// time since the last learned step < kFollows steps: it follows on it without a gap.
constexpr double kFollows = 1.5;

// What it is.
/// steps that are kept to isolate a cause <= kRecent [s].
constexpr double kRecent = 20.0;
/// gain of the best cause - gain of another < kOdds * dispersion: they are rivals; twice the logarithm of odds
/// of 100 to 1.
constexpr double kOdds = 9.2;
/// steps with these odds >= kLikelyInARow: it is named ...
constexpr int kLikelyInARow = 4;
/// ... and time since the onset >= kSoonestName [s], because a push may still end.
constexpr double kSoonestName = 2.0;
/// gain of the cause > kExplains * gain of free torques, else a push or nothing that is known.
constexpr double kExplains = 0.6;
/// time without a push > kPushEnds [s]: it is over.
constexpr double kPushEnds = 0.8;
/// a push >= kShortestPush [s], constant over kSegment [s] each.
constexpr double kShortestPush = 0.2;
constexpr double kSegment = 0.5;
/// share of the gain that a joint brings > kActive: the push is named on it.
constexpr double kActive = 0.1;
/// innovations > kMixed steps after the onset: those before mix both states.
constexpr double kMixed = 2.5;
/// friction <= kLargestTorques * rms torque of the joint: none grows beyond it.
constexpr double kLargestTorques = 3.0;
/// centre of a load = kLever [m] off its frame, mass >= kLightest [kg].
constexpr double kLever = 0.1;
constexpr double kLightest = 0.01;
/// information of a column > kNothing, else it is not there.
constexpr double kNothing = 1e-12;
/// relative systematic error of a size = kSystematic: smoothing, first-order columns.
constexpr double kSystematic = 0.02;
/// probability outside of an interval = kOutside.
constexpr double kOutside = 0.05;
/// what is left of a change < kReversalShare of it: it was reversed.
constexpr double kReversalShare = 0.3;
/// gain > kPresentOdds * kOdds of a change that was there in the beginning: all hypotheses are compared ...
constexpr double kPresentOdds = 3.0;
/// ... and its torque >= kPresentShare of the joint's rms torque: less differs from day to day.
constexpr double kPresentShare = 0.1;
/// names of one change that are withdrawn < kMostWithdrawn, so that two causes do not alternate.
constexpr int kMostWithdrawn = 2;

}  // namespace veridyn::watching
