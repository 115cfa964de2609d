#pragma once

#include <cstddef>

namespace veridyn::numerics {

/// Numbers for safe arithmetic, resolutions and texts. The evidence that a named cause needs is in Thresholds
/// and in search/numbers.hpp.

constexpr double kTiny = 1e-300;  ///< smallest divisor, smallest argument of a logarithm
constexpr double kHuge = 1e300;   ///< a bound that is never reached
constexpr double kNoise = 1e-12;  ///< share that may remain by rounding
constexpr double kOutside = 0.05;  ///< probability outside of an interval that is printed
constexpr double kPercent = 100.0;
constexpr double kWhole = 0.995;  ///< share of the error above which findings count as a complete explanation, printed as 100 %
constexpr double kDegrees = 57.29577951308232;  ///< Degrees of a radian

constexpr double kContactMargin = 0.25;   ///< [s] left out on either side of a contact
constexpr double kContactFreedom = 10.0;  ///< independent moments from which the scatter of a residual is estimated

// Curves in words.
constexpr double kShapeFlat = 0.15;  ///< share of a curve's range within which a part of the curve counts as constant
constexpr double kShapeMost = 0.8;   ///< share of a curve's mean square above which the curve counts as odd, or even

// Resolution.
constexpr double kVibrationWaves = 3.0;  ///< fewest waves in a recording; fewer cannot be distinguished from drift
constexpr double kVibrationStep = 0.25;  ///< step of the frequency grid, in waves of the longest recording
constexpr int kCurvePoints = 41;         ///< points of a printed curve
constexpr int kCurvePointsOfTwo = 9;     ///< points along each side of a printed surface
constexpr int kWindows = 5;              ///< curves that represent a function of two signals

// Text.
constexpr std::size_t kNamedParameters = 3;
constexpr std::size_t kNumberWidth = 8;

}  // namespace veridyn::numerics
