#pragma once

namespace veridyn::numerics {

/// Numbers that keep arithmetic sound and decide nothing; those that decide are in Thresholds.

constexpr double kTiny = 1e-300;  ///< smallest divisor, smallest argument of a logarithm
constexpr double kHuge = 1e300;   ///< no bound at all
constexpr double kNoise = 1e-12;  ///< a share that rounding may leave
constexpr double kRidge = 1e-11;  ///< of a column's square: equal columns do not divide by zero
constexpr double kOutside = 0.05;  ///< probability outside of an interval that is printed
constexpr double kPercent = 100.0;
constexpr double kDegrees = 57.29577951308232;  ///< of a radian
constexpr double kMadToDeviation = 1.4826;  ///< of a normal distribution

constexpr double kMinute = 60.0;     ///< [s]
constexpr double kThousand = 1e3;

// Contacts are looked for in the residual without what changes slowly.
constexpr double kContactMedian = 4.0;    ///< [s] on either side, of the median that follows it
constexpr double kContactGrid = 0.25;     ///< [s]
constexpr double kContactJoin = 0.5;      ///< [s] bursts nearer than this are one
constexpr double kContactMargin = 0.25;   ///< [s] left out on either side
constexpr double kContactFreedom = 10.0;  ///< scatter of a residual is known from some tens of
                                          ///< independent moments
constexpr double kMovingShare = 0.02;     ///< of the largest speed: a joint moves
constexpr double kMoves = 0.02;           ///< [rad/s] or [m/s]: it moves in this recording at all

// Local friction by place.
constexpr double kSnagMovingShare = 0.03;  ///< of the largest speed: slower says nothing about it

// How a constant of the robot file is searched: what lies beyond the reach is no optimum inside.
constexpr double kGeometryRate = 10.0;   ///< [Hz] of the samples: the motions of a rigid arm
constexpr double kAngleStep = 0.05;      ///< [rad]; also of a ratio
constexpr double kAngleReach = 0.6;
constexpr double kLengthStep = 0.01;     ///< [m]
constexpr double kLengthReach = 0.15;
constexpr double kOffCentre = 0.7;       ///< of a step: where nothing vanishes by symmetry
constexpr double kBracketGrowth = 1.6;
constexpr double kGolden = 0.381966011250105;  ///< 2 - golden ratio

}  // namespace veridyn::numerics
