#pragma once

#include <cstddef>

namespace veridyn::numerics {

/// Numbers for safe arithmetic, resolutions, and texts. What evidence must reach before a cause is
/// named is in Thresholds and in search/numbers.hpp.

constexpr double kTiny = 1e-300;  ///< smallest divisor, smallest argument of a logarithm
constexpr double kHuge = 1e300;   ///< a bound that is never reached
constexpr double kNoise = 1e-12;  ///< a share that rounding may leave
constexpr double kOutside = 0.05;  ///< probability outside of an interval that is printed
constexpr double kPercent = 100.0;
constexpr double kWhole = 0.995;  ///< share from which names count as explaining everything, printed as 100 %
constexpr double kDegrees = 57.29577951308232;  ///< Degrees of a radian

constexpr double kContactMargin = 0.25;   ///< [s] left out in addition on either side of a contact
constexpr double kContactFreedom = 10.0;  ///< scatter of a residual is known from some tens of independent moments

// Curves in words.
constexpr double kShapeFlat = 0.15;  ///< share of a curve's range within which a part of it counts as constant
constexpr double kShapeMost = 0.8;   ///< share of a curve's mean square, beyond which it counts as odd, or even

// Resolution.
constexpr double kVibrationWaves = 3.0;  ///< waves in a recording; fewer cannot be distinguished from drift
constexpr double kVibrationStep = 0.25;  ///< step of the frequency grid, in waves of the longest recording
constexpr std::size_t kMostPoses = 1000;  ///< poses at rest that curves are fitted to; of more, every second or third
constexpr double kCurveWidth = 0.25;      ///< width of a curve's kernel, as a share of a position's range
constexpr double kCurveRidges[] = {0.01, 0.1, 1.0, 10.0};  ///< noise beside what curves explain, from nearly free to nearly flat
constexpr int kCurvePoints = 41;         ///< points of a printed curve
constexpr int kCurvePointsOfTwo = 9;     ///< points along each side of a printed surface
constexpr int kWindows = 5;              ///< curves that a table over two signals is made of

// Text.
constexpr std::size_t kNamedParameters = 3;
constexpr std::size_t kNumberWidth = 8;

}  // namespace veridyn::numerics
