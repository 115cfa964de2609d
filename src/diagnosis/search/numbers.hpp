#pragma once

#include <cstddef>

namespace veridyn::search {

// Numbers of the search. Those that decide come first.

/// gain of a term >= kErrors * its standard error over blocks (kPassed of Student's distribution below kManyBlocks), where
/// no held-out recording can repeat the test; else
/// >= kRepeated * its standard error, and once more on the held-out recordings, to which no term is fitted. A joint that
/// gets worse by kErrors * the standard error refutes a term.
constexpr double kErrors = 2.0, kPassed = 0.97725, kRepeated = 1.0;
constexpr int kManyBlocks = 30;
/// fall of the mean square of the joint that a term helps most >= kSmallest: less is not worth a name.
constexpr double kSmallest = 0.02;
/// ln of the prior odds of a name that often is the cause against one that seldom is, a constant of the robot file, one
/// that can imitate many others, and curves of one and of two signals; the priors of a dictionary sum to one.
constexpr double kSeldom = 2.0, kConstantPrice = 4.0, kImitator = 3.5, kCurveOfOne = 5.0, kCurveOfTwo = 6.5;
/// nats of a number that is polished, and of every parameter beyond the first.
constexpr double kPolished = 1.0;
/// deviation of friction levels and offsets from day to day, as a share of the level.
constexpr double kDay = 0.1;
/// ln of the posterior odds of a term >= kOdds (ten to one) where no held-out recording repeats its test.
constexpr double kOdds = 2.3;
/// variance of the noise beside the scatter of a MODEL's values = kNoisePart * the mean scatter of their torques; it adds at most
/// kUncorrelatedPart of its own variance to a value.
constexpr double kNoisePart = 0.5, kUncorrelatedPart = 0.05;
/// gain of another term >= kHalf * that of a linearised term: it is compared as a rival; gain of names >= kHalf * that of a
/// curve: it does not stand for them.
constexpr double kHalf = 0.5;
/// mean of half a second of what is left over >= kMomentSize scales, its peak >= kPeak scales and kTorqueShare of the
/// joint's largest torque, for kShortest [s] or more, in less than kMostOfTime of the recording: a push.
constexpr double kMomentSeconds = 0.5, kMomentSize = 2.2, kPeak = 4.0, kTorqueShare = 0.04, kShortest = 0.4, kMostOfTime = 0.2;
/// error of the held-out recordings >= kDiffers * that of the training recordings: no floor.
constexpr double kDiffers = 3.0;
/// error of a joint <= kAtFloor * its floor: at the floor.
constexpr double kAtFloor = 1.15;

// Numbers that set the resolution.
constexpr double kFreedom = 4.0;             ///< degrees of freedom of the Student-t loss
constexpr double kBlockSeconds = 2.5;        ///< [s] of a block: rows of one are not independent
constexpr int kFewestBlocks = 16;            ///< of all recordings together
constexpr std::size_t kWholeRecordings = 3;  ///< from so many recordings on folds are whole ones
constexpr int kParts = 6;                    ///< folds otherwise
constexpr double kUncorrelated = 0.05;       ///< autocorrelation of the residual, below which rows count as independent
constexpr int kMostLags = 200;               ///< rows over which the autocorrelation is summed
constexpr double kLargestPart = 10.0;        ///< rms of one parameter's torque, in those of the joint's torque
constexpr double kDependent = 1e-10;         ///< smallest eigenvalue of scaled columns that count as independent
constexpr int kRandomStates = 200;            ///< states at which torques under other directions of gravity are compared
constexpr double kHidden = 1e-6;             ///< share of the largest sum of squares, below which a direction has no torque
constexpr double kLeastScale = 1e-4;         ///< smallest residual, as a share of the joint's rms torque
constexpr int kBoundTurns = 5;               ///< of the levels that cannot be negative
constexpr double kAtBound = 1e-9;            ///< below zero: of the largest level
constexpr int kScaleSteps = 60;              ///< most steps to the scale of a Student-t distribution
constexpr double kSameScale = 1e-9;          ///< last step, of ln of its square
constexpr int kLogsAtOnce = 8;               ///< factors of a product whose logarithm is taken
constexpr int kReweighted = 3;               ///< fits of a round with new weights
constexpr double kInSpan = 1e-7;             ///< share of a column that other columns do not span: less is none
constexpr double kColumnRidge = 1e-9, kGramRidge = 1e-10;  ///< of the diagonal
constexpr double kCurveSize = 3.0;           ///< prior deviation of a curve's coefficients, in scales of the residual
constexpr int kFinalists = 6;                ///< terms of different kinds that are polished and compared exactly
constexpr int kScreened = 40;                ///< terms that are compared exactly before
constexpr double kWorthPolish = 0.6;         ///< of the gain that is needed: a grid value below is not polished
constexpr int kRounds = 12;                  ///< additions beyond the most that are asked for
constexpr int kTurns = 3;                    ///< rounds of exchanges after each addition
constexpr int kSections = 5;                 ///< steps of the polish of one number
constexpr double kSearchGolden = 0.381966011250105;
constexpr double kBetter = 0.5;              ///< [nats] by which an exchange must lower the score
constexpr int kSteps = 6;                    ///< of a linearised term
constexpr double kSettled = 0.05;            ///< share of a deviation, below which a step has converged
constexpr double kShortestStep = 0.2, kLittle = 0.1;  ///< of a step; [nats] that end the steps
constexpr double kGainOfNothing = -0.95;     ///< error of a factor at which it turns a torque round
constexpr double kFarGravity = 0.1;          ///< of gravity: nearer directions are reached by steps
/// prior deviations of a load [kg], [m], and of its inertia beyond that of a point [kg m^2], also as that of a radius of
/// gyration [m]: what no torque sees stays small
constexpr double kMassOfArm = 30.0, kReach = 0.5, kInertia = 0.02, kGyration = 0.05;
constexpr double kSeen = 0.1;                ///< share of a first moment's prior deviation, below which torques determine it
constexpr double kNoMass = 1e-6;             ///< [kg] of a load
constexpr double kAlongJoint = 0.999;        ///< cosine of an axis that is a joint's own
constexpr double kFirstProfile = 0.02;       ///< first step of the profile of a shape
constexpr std::size_t kMostRivals = 4, kMostRefused = 60, kMostWholeArm = 3;

constexpr std::size_t kFewestRows = 50;      ///< of a recording in which pushes are sought

// The dictionary.
constexpr double kStill = 5e-3, kStillLength = 5e-4;  ///< [rad], [m] travel of a joint that counts as at rest
constexpr double kRestShare = 0.02;          ///< of the largest speed: slower is no reversal
constexpr int kCurveIntervals = 8, kSideIntervals = 5, kProductIntervals = 3;  ///< of a curve over one signal, for each direction, along each of two
constexpr double kFirstWave = 3.0, kLastWave = 600.0, kWaveGrid = 0.5;  ///< waves per travel of a spectrum
constexpr double kProminence = 4.0;          ///< of a spectral line over the median
constexpr std::size_t kMostLines = 3;        ///< of one joint
constexpr double kAngleReach = 0.6, kLengthReach = 0.15;  ///< [rad], also of a ratio, and [m] of a constant
constexpr double kDifference = 1e-4;         ///< [rad] or [m] of derivatives by a constant
constexpr double kQuarter = 0.25;            ///< of a range: step of a shape whose grid has one value

}  // namespace veridyn::search
