#pragma once

#include <cstddef>

namespace veridyn::search {

// Numbers of the search. Those that decide come first.

/// gain of a term >= kErrors * its standard error over blocks (the same quantile of Student's below 30 blocks).
constexpr double kErrors = 2.5;
/// fall of the mean square of the joint that a term helps most >= kSmallest: less is not worth a name.
constexpr double kSmallest = 0.02;
/// ln of the prior odds of a name that seldom is the cause, of one that can imitate many others, and of a curve
/// without a name, against a name that often is; the priors of a dictionary sum to one.
constexpr double kSeldom = 2.0, kImitator = 3.5, kCurve = 5.0, kCurveOfTwo = 6.5;
/// nats of a number that is polished.
constexpr double kPolished = 1.0;
/// deviation of friction levels and offsets from day to day, as a share of the level.
constexpr double kDay = 0.1;

// Numbers that set the resolution.
constexpr double kFreedom = 4.0;          ///< degrees of freedom of the Student-t loss
constexpr double kBlockSeconds = 2.5;     ///< [s] of a block: rows of one are not independent
constexpr int kFewestBlocks = 8;          ///< of one recording
constexpr std::size_t kWholeRecordings = 3;  ///< from so many recordings on folds are whole ones
constexpr int kParts = 6;                 ///< folds otherwise
constexpr double kUncorrelated = 0.05;    ///< autocorrelation at which it counts as none
constexpr int kMostLags = 200;            ///< rows over which it is summed
constexpr double kDependent = 1e-10;      ///< smallest eigenvalue of scaled columns that count as independent
constexpr double kLeastScale = 1e-4;      ///< smallest residual, as a share of the joint's rms torque
constexpr int kFinalists = 6;             ///< terms of different kinds that are polished and compared exactly
constexpr int kRounds = 12;               ///< additions at most
constexpr int kTurns = 3;                 ///< rounds of exchanges after each addition
constexpr int kSections = 5;              ///< steps of the polish of one number

}  // namespace veridyn::search
