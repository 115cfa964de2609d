#pragma once

#include <array>
#include <cstddef>

namespace veridyn::numerics {

/// Numbers that keep arithmetic sound, and the resolution, the rounds and the memory of searches. What evidence must
/// reach before a cause is named is in Thresholds; numbers here only decide what a search can see at all.

// Remainder of a load column outside the span of its other columns, squared and relative.
constexpr double kLoadRank = 1e-6;
constexpr double kTiny = 1e-300;  ///< smallest divisor, smallest argument of a logarithm
constexpr double kHuge = 1e300;   ///< stands for a bound that is never reached
constexpr double kNoise = 1e-12;  ///< a share that rounding may leave
/// Relative ridge of the diagonal, so that equal columns can be solved for.
constexpr double kRidge = 1e-11;
constexpr double kOutside = 0.05;  ///< probability outside of an interval that is printed
constexpr double kPercent = 100.0;
constexpr double kWhole = 0.995;  ///< share that is printed as 100 %: what names take above it, they take whole
constexpr double kDegrees = 57.29577951308232;  ///< Degrees of a radian

constexpr double kMinute = 60.0;     ///< [s]
constexpr double kThousand = 1e3;

// Contacts are sought in the residual minus its slow part.
constexpr double kContactMedian = 4.0;    ///< [s] half width of the median that gives the slow part
constexpr double kContactGrid = 0.25;     ///< [s]
constexpr double kContactJoin = 0.5;      ///< [s] bursts nearer than this are one
constexpr double kContactMargin = 0.25;   ///< [s] excluded in addition on either side
constexpr double kContactFreedom = 10.0;  ///< scatter of a residual is known from some tens of
                                          ///< independent moments

// Search of a constant of the robot file: an optimum beyond the reach is none.
constexpr double kGeometryRate = 10.0;   ///< [Hz] of the samples: the motions of a rigid arm
constexpr double kAngleStep = 0.05;      ///< [rad]; also of a ratio
constexpr double kAngleReach = 0.6;
constexpr double kLengthStep = 0.01;     ///< [m]
constexpr double kLengthReach = 0.15;
/// Evaluation point off the grid node, where nothing vanishes by symmetry.
constexpr double kOffCentre = 0.7;
constexpr double kBracketGrowth = 1.6;
constexpr double kGolden = 0.381966011250105;  ///< 2 - golden ratio

// Search of shape constants: factors around the present value, wide ones first.
constexpr std::array<std::array<double, 6>, 3> kShapeFactors = {
    {{0.4, 0.6, 0.8, 1.25, 1.6, 2.5}, {0.7, 0.8, 0.9, 1.12, 1.25, 1.4},
     {0.85, 0.9, 0.95, 1.05, 1.1, 1.15}}};
/// Factors of the profile that gives the interval of a constant.
constexpr std::array<double, 14> kShapeProfile = {0.01, 0.03, 0.1, 0.2, 0.4, 0.65, 0.85,
                                                  1.15, 1.5, 2.5, 5.0, 10.0, 30.0, 100.0};
constexpr double kWaveStep = 0.4;     ///< relative step of the wave number, in waves per travel
constexpr double kShapeOpen = 0.03;   ///< half a step of the last factors: resolution of the search
constexpr double kSmallestTravel = 1e-6;
constexpr double kSameAxis = 1e-9;    ///< tolerance of equal directions

// Residuals against signals.
/// Share of the largest speed, below which a reversal is not counted.
constexpr double kReversalShare = 0.02;
/// Share of the travel: resolution of displacements after a reversal.
constexpr double kHistoryUnit = 0.005;
constexpr double kRowsPerCutoff = 5.0;   ///< rows per period of the cut-off frequency
constexpr double kSparseEnds = 0.01;     ///< share of the rows, at either end of a signal, where a curve has too little support
constexpr double kShapeFlat = 0.15;      ///< share of a curve's range within which a part of it counts as constant
/// Share of a curve's mean square, beyond which it counts as odd, or even.
constexpr double kShapeMost = 0.8;

// Loads.
/// Relative curvature below which a direction is unobservable.
constexpr double kUnseenLoad = 1e-7;
constexpr double kSameSpan = 1e-5;    ///< tolerance for two loads that span the same columns
constexpr double kLightest = 1e-4;    ///< [kg] where the torques see the moment only
constexpr double kHeaviest = 200.0;   ///< [kg]
constexpr double kAnywhere = 1e6;     ///< [m]
constexpr double kAsGoodLoad = 2e-3;  ///< relative cost that counts as a tie
constexpr std::array<double, 5> kFirstMasses = {0.03, 0.15, 0.6, 2.5, 10.0};  ///< [kg]
constexpr double kFirstDamping = 1e-3;
constexpr double kMoreDamping = 8.0;
constexpr double kLessDamping = 0.2;
constexpr double kMostDamping = 1e8;
constexpr double kConverged = 1e-13;
constexpr double kFirstPlaces = 0.3;  ///< initial offsets as a share of the reach
constexpr double kLoadPrior = 1e-6;

// Rounds of a search that ends before them where it has converged.
constexpr int kChannelSteps = 8;   ///< Newton steps for the constant of a channel error
constexpr int kHalvings = 3;       ///< halvings of a step that makes the fit worse
constexpr int kStepsTogether = 4;  ///< joint steps for a channel error and the causes that became visible with it
constexpr int kPayloadTurns = 6;   ///< alternations between friction and load, where a CAD model has no friction
constexpr int kRefinements = 14;   ///< golden sections of the bracket around a constant
constexpr int kDescentSteps = 60;  ///< Levenberg-Marquardt steps for a point mass

// Resolution, and the samples that it needs.
constexpr int kPhases = 8;    ///< phases of a period, compared across recordings
constexpr int kPeriods = 20;  ///< periods before and after a burst, at which it may recur
constexpr std::size_t kFewestContactSamples = 50;
constexpr int kPassSamples = 64;        ///< grid points of one pass over a joint's travel
constexpr int kTravelBins = 40;         ///< bins of the travel that all recordings cover
constexpr int kFewestInBin = 6;         ///< samples that a bin needs in either direction
constexpr int kSpectrumSamples = 4000;  ///< samples of a spectrum, shared by all recordings
constexpr std::size_t kFewestSpectrumSamples = 100;
constexpr double kVibrationWaves = 3.0;         ///< waves in a recording; fewer cannot be told from drift
constexpr double kVibrationStep = 0.25;         ///< step of the frequency grid, in waves of the longest recording
constexpr int kConstantParts = 8;               ///< parts of a recording, for the scatter of a constant
constexpr int kMostConstantParts = 64;          ///< parts of all recordings: they are in memory together
constexpr std::size_t kMostMotionRows = 6000;   ///< rows of all recordings together
constexpr std::size_t kFewestMotionRows = 300;  ///< rows that each recording keeps
constexpr int kIntervals = 20;                  ///< spline intervals over one signal
constexpr int kIntervalsOnSides = 12;           ///< spline intervals for each direction of motion
constexpr int kIntervalsOfTwo = 3;              ///< spline intervals along each of two signals
constexpr int kCurvePoints = 41;                ///< points of a printed curve
constexpr int kCurvePointsOfTwo = 9;            ///< points along each side of a printed surface
constexpr int kWindows = 5;                     ///< curves that a table over two signals is made of

// Memory.
constexpr int kAskedColumns = 50;    ///< columns of one joint's candidates
constexpr int kAskedFromOthers = 4;  ///< columns more for each further joint
constexpr int kFewestBlocks = 8;     ///< blocks of all recordings together

// Text.
constexpr std::size_t kNamedParameters = 3;
constexpr std::size_t kListed = 60;  ///< causes printed as ruled out
constexpr std::size_t kNumberWidth = 8;

}  // namespace veridyn::numerics
