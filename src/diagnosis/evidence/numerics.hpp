#pragma once

#include <array>

namespace veridyn::numerics {

/// Numbers that keep arithmetic sound and decide nothing; those that decide are in Thresholds.

constexpr double kLoadRank = 1e-6;  // share of a load column's square that its other columns do not span
constexpr double kTiny = 1e-300;  ///< smallest divisor, smallest argument of a logarithm
constexpr double kHuge = 1e300;   ///< no bound at all
constexpr double kNoise = 1e-12;  ///< a share that rounding may leave
constexpr double kRidge = 1e-11;  ///< Ridge of a column's square: equal columns do not divide by zero
constexpr double kOutside = 0.05;  ///< probability outside of an interval that is printed
constexpr double kPercent = 100.0;
constexpr double kDegrees = 57.29577951308232;  ///< Degrees of a radian
constexpr double kMadToDeviation = 1.4826;  ///< Mad to deviation of a normal distribution

constexpr double kMinute = 60.0;     ///< [s]
constexpr double kThousand = 1e3;

// Contacts are looked for in the residual without what changes slowly.
constexpr double kContactMedian = 4.0;    ///< [s] on either side, of the median that follows it
constexpr double kContactGrid = 0.25;     ///< [s]
constexpr double kContactJoin = 0.5;      ///< [s] bursts nearer than this are one
constexpr double kContactMargin = 0.25;   ///< [s] left out on either side
constexpr double kContactFreedom = 10.0;  ///< scatter of a residual is known from some tens of
                                          ///< independent moments

// How a constant of the robot file is searched: what lies beyond the reach is no optimum inside.
constexpr double kGeometryRate = 10.0;   ///< [Hz] of the samples: the motions of a rigid arm
constexpr double kAngleStep = 0.05;      ///< [rad]; also of a ratio
constexpr double kAngleReach = 0.6;
constexpr double kLengthStep = 0.01;     ///< [m]
constexpr double kLengthReach = 0.15;
constexpr double kOffCentre = 0.7;       ///< Off centre of a step: where nothing vanishes by symmetry
constexpr double kBracketGrowth = 1.6;
constexpr double kGolden = 0.381966011250105;  ///< 2 - golden ratio

// Search of shape constants: factors around the present value, wide ones first.
constexpr std::array<std::array<double, 6>, 3> kShapeFactors = {
    {{0.4, 0.6, 0.8, 1.25, 1.6, 2.5}, {0.7, 0.8, 0.9, 1.12, 1.25, 1.4},
     {0.85, 0.9, 0.95, 1.05, 1.1, 1.15}}};
constexpr double kWaveStep = 0.4;     ///< Wave step of one wave per travel: steps of an order
constexpr double kShapeOpen = 0.03;   ///< half a step of the last factors: what the search leaves open
constexpr double kSmallestTravel = 1e-6;
constexpr double kSameAxis = 1e-9;    ///< by which directions may differ

// Residuals against signals.
constexpr double kReversalShare = 0.02;  ///< of the largest speed: slower is no new direction
constexpr double kHistoryUnit = 0.005;   ///< of the travel: ways after a reversal that are told apart
constexpr double kRowsPerCutoff = 5.0;   ///< rows per period of the cut-off frequency
constexpr double kSparseEnds = 0.01;     ///< of the rows at either end of a signal: too few for a curve
constexpr double kShapeFlat = 0.15;      ///< of a curve's range: it keeps its value
constexpr double kShapeMost = 0.8;       ///< of a curve's mean square: it is odd, or even

// Loads.
constexpr double kUnseenLoad = 1e-7;  ///< Unseen load of the best seen direction's square
constexpr double kSameSpan = 1e-5;    ///< Same span of a column's square that may lie outside the other load's
constexpr double kLightest = 1e-4;    ///< [kg] where the torques see the moment only
constexpr double kHeaviest = 200.0;   ///< [kg]
constexpr double kAnywhere = 1e6;     ///< [m]
constexpr double kAsGoodLoad = 2e-3;  ///< As good load of what the best solution explains
constexpr std::array<double, 5> kFirstMasses = {0.03, 0.15, 0.6, 2.5, 10.0};  ///< [kg]
constexpr double kFirstDamping = 1e-3;
constexpr double kMoreDamping = 8.0;
constexpr double kLessDamping = 0.2;
constexpr double kMostDamping = 1e8;
constexpr double kConverged = 1e-13;
constexpr double kFirstPlaces = 0.3;  ///< First places of the reach
constexpr double kLoadRidge = 1e-10;
constexpr double kLoadPrior = 1e-6;

}  // namespace veridyn::numerics
