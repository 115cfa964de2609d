#pragma once

#include <cstddef>

namespace veridyn::search {

// Numbers of the search. Those that decide come first.

/// gain of a term >= kStandardErrorsWithoutTest * its standard error over blocks where no held-out recording can repeat the
/// test (below kManyBlocks the quantile kProbabilityWithoutTest of Student's distribution takes its place); else
/// >= kStandardErrorsWithTest * its standard error, and once more on the held-out recordings, to which no term is fitted.
constexpr double kStandardErrorsWithoutTest = 2.0, kProbabilityWithoutTest = 0.97725, kStandardErrorsWithTest = 1.0;
constexpr int kManyBlocks = 30;
/// loss of a joint >= kLossShare * the gain on all joints, beyond its error and with a rise of kSmallestDecrease: the term is refuted.
constexpr double kLossShare = 0.1;
/// relative decrease of the mean square of the joint that a term helps most >= kSmallestDecrease, against a MODEL >=
/// kSmallestChange, else the term does not matter.
constexpr double kSmallestDecrease = 0.02, kSmallestChange = 0.05;
/// ln of the prior odds of a frequent cause against a seldom one (kPriceOfSeldom), a constant of the robot file, one
/// that can imitate many others, and curves of one and of two signals; the priors of a dictionary sum to one.
constexpr double kPriceOfSeldom = 2.0, kConstantPrice = 4.0, kImitator = 3.5, kCurveOfOne = 5.0, kCurveOfTwo = 6.5;
/// price [nats] of a shape constant that is refined, and of every parameter beyond the first.
constexpr double kPolished = 1.0;
/// deviation of friction levels and offsets from day to day, as a share of the level.
constexpr double kDailyFrictionDeviation = 0.1;
/// ln of the posterior odds of a term >= kLnPosteriorOdds (ten to one) where no held-out recording repeats its test.
constexpr double kLnPosteriorOdds = 2.3;
/// variance of the noise beside the scatter of a MODEL's values = kNoisePart * the mean scatter of their torques; it adds at most
/// kUncorrelatedPart of its own variance to a value.
constexpr double kNoisePart = 0.5, kUncorrelatedPart = 0.05;
/// gain of another term >= kRivalGainShare * that of a linearised term: it is compared as a rival; gain of named terms >=
/// kRivalGainShare * that of a curve: the curve does not replace them.
constexpr double kRivalGainShare = 0.5;
/// mean of half a second of what is left over >= kMomentSize scales, its peak >= kPeak times the size that kUsualShare of the
/// means stay below (at least one scale) and >= kTorqueShare of the joint's largest torque, for kShortest [s] or more, in
/// less than kMostOfTime of the recording: a push.
constexpr double kMomentSeconds = 0.5, kMomentSize = 2.2, kUsualShare = 0.75, kPeak = 6.0, kTorqueShare = 0.04, kShortest = 0.4, kMostOfTime = 0.2;
/// error of the held-out recordings >= kDiffers * that of the training recordings: no floor.
constexpr double kDiffers = 3.0;
/// error of a joint <= kAtFloor * its floor: at the floor.
constexpr double kAtFloor = 1.15;

// Numbers that set the resolution.
constexpr double kFreedom = 4.0;             ///< degrees of freedom of the Student-t loss
constexpr double kBlockSeconds = 2.5;        ///< [s] of a block: rows of one are not independent
constexpr int kFewestBlocks = 16;            ///< smallest number of blocks of all recordings together
constexpr std::size_t kWholeRecordings = 3;  ///< from this number of recordings on, folds are whole recordings
constexpr int kParts = 6;                    ///< number of folds otherwise
constexpr double kUncorrelated = 0.05;       ///< autocorrelation of the residual, below which rows count as independent
constexpr int kMostLags = 200;               ///< rows over which the autocorrelation is summed
constexpr double kLargestPart = 10.0;        ///< largest rms of one parameter's torque, relative to that of the joint's torque
constexpr double kDependent = 1e-10;         ///< smallest eigenvalue of scaled columns that count as independent
constexpr int kRandomStates = 200;           ///< states at which torques under other directions of gravity are compared
constexpr double kHidden = 1e-6;             ///< share of the largest sum of squares, below which a direction has no torque
constexpr double kLeastScale = 1e-4;         ///< smallest residual, as a share of the joint's rms torque
constexpr int kBoundTurns = 5;               ///< largest number of extensions of the set of levels that are held at zero
constexpr double kAtBound = 1e-9;            ///< share of the largest level, by which a level may be below zero
constexpr int kScaleSteps = 60;              ///< largest number of steps to the scale of a Student-t distribution
constexpr double kSameScale = 1e-9;          ///< change of ln of its square, below which the steps end
constexpr int kLogsAtOnce = 8;               ///< number of factors of a product whose logarithm is taken
constexpr int kReweighted = 3;               ///< number of fits of a round, each with new weights
constexpr double kInSpan = 1e-7;             ///< share of a column outside the span of the others; less counts as zero
constexpr double kColumnRidge = 1e-9, kGramRidge = 1e-10;  ///< shares of the diagonal
constexpr double kCurveSize = 3.0;           ///< prior deviation of a curve's coefficients, in scales of the residual
constexpr int kFinalists = 6;                ///< number of terms of different kinds that are polished and compared exactly
constexpr int kScreened = 40;                ///< number of terms that are compared exactly before polishing
constexpr double kWorthPolish = 0.6;         ///< share of the required gain, below which a value of the grid is not polished
constexpr int kRounds = 12;                  ///< rounds beyond the largest number of findings
constexpr int kTurns = 3;                    ///< rounds of exchanges after each addition
constexpr int kSections = 5;                 ///< golden sections for one shape constant
constexpr double kSearchGolden = 0.381966011250105;
constexpr double kExchangeGain = 0.5;        ///< [nats] by which an exchange must lower the score
constexpr int kSteps = 6;                    ///< largest number of steps of a linearised term
constexpr double kConvergedStep = 0.05;      ///< share of a standard deviation, below which a step has converged
constexpr double kShortestStep = 0.2, kNegligibleGain = 0.1;  ///< shortest part of a step that is tried; gain [nats] below which no further step is taken
constexpr double kSignReversingGain = -0.95;  ///< smallest error of a factor: below -1 it would reverse the torque's sign
constexpr double kFarGravity = 0.1;          ///< share of gravity: nearer directions are reached by steps
constexpr double kSmallLean = 0.5;           ///< share of gravity: up to such a difference from the file's, base parameters are those of the leaning arm
/// prior deviations of a load [kg], [m], and of its inertia beyond that of a point [kg m^2], also as that of a radius of
/// gyration [m]: values that the torques do not determine stay small
constexpr double kMassOfArm = 30.0, kReach = 0.5, kInertia = 0.02, kGyration = 0.05;
constexpr double kDeterminedShare = 0.1;     ///< share of a first moment's prior deviation, below which torques determine it
constexpr double kNoMass = 1e-6;             ///< [kg] of a load
constexpr double kAlongJoint = 0.999;        ///< cosine of an axis that is a joint's own
constexpr double kFirstProfile = 0.02;       ///< first step of the profile of a shape
constexpr std::size_t kMostRivals = 4, kMostRejected = 60, kMostWholeArm = 3;

constexpr std::size_t kFewestRows = 50;      ///< rows of a recording >= kFewestRows, else no pushes are sought in it

// The dictionary.
constexpr double kStill = 5e-3, kStillLength = 5e-4;  ///< [rad], [m] travel of a joint that counts as at rest
constexpr double kRestShare = 0.02;          ///< share of the largest speed: a slower motion is no reversal
constexpr int kCurveIntervals = 8, kSideIntervals = 5, kProductIntervals = 3;  ///< intervals of a curve over one signal, for each direction of motion, along each of two signals
constexpr double kFirstWave = 3.0, kLastWave = 600.0, kWaveGrid = 0.5;  ///< waves per travel of a spectrum
constexpr double kProminence = 4.0;          ///< smallest ratio of a spectral line to the median
constexpr std::size_t kMostLines = 3;        ///< largest number of lines of one joint
constexpr double kAngleReach = 0.6, kLengthReach = 0.15;  ///< [rad], also for a ratio, and [m]: largest error of a constant
constexpr double kDifference = 1e-4;         ///< [rad] or [m] step of numerical derivatives with respect to a constant
constexpr double kQuarterOfRange = 0.25;     ///< share of a shape's range: its step if its grid has one value

}  // namespace veridyn::search
