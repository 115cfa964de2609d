#pragma once

namespace veridyn {

/// All numbers that can change the result of `compare`, each with its inequality, and with its
/// reason where one is known.
struct ComparisonNumbers {
  /// change / rms torque of a parameter < rounded_away: an error of sampling in time, counted as no change; so is what one
  /// factor of all torques leaves.
  double rounded_away = 5e-3;
  /// relative error of a file's base parameters <= from_values: they are those of its values.
  double from_values = 1e-6;
  /// distance of two motions < same_motion of their spread over clusters: one motion, compared in pairs.
  double same_motion = 0.2;
  /// value before > surely_there deviations: a percentage is printed.
  double surely_there = 3.0;
  /// training error of a joint > fits_worse * that of the other model: differences may be errors of the model.
  double fits_worse = 3.0;
};

/// Numbers that change no result: rounding, a moment of the normal distribution, and how numbers are printed.
namespace comparing {

constexpr ComparisonNumbers numbers;

/// fourth moment of a normal distribution = kKurtosis of its squared variance, less what equal clusters
/// would give by chance.
constexpr double kKurtosis = 3.0;
/// time < end of the last whole period - kSameTime [s]: it counts.
constexpr double kSameTime = 1e-9;
/// |difference| <= kSameToRounding * the larger one counts as a deviation: rounding in files, and the
/// discretisation of a noise-free recording; 1e-9 and 1e-3 do the same.
constexpr double kSameToRounding = 1e-6;
/// part of a combination outside the span <= kInSpan: the other model determines it; 1e-8 and 1e-2 do the same.
constexpr double kInSpan = 1e-5;
/// probability outside of an interval = kOutside.
constexpr double kOutside = 0.05;
/// |a - b| <= kSame * (1 + |a|): equal; files round by less.
constexpr double kSame = 1e-9;
/// digits of a value without a deviation >= those of kDigits of it.
constexpr double kDigits = 1e-3;
/// differences of a list that are printed <= kListed.
constexpr int kListed = 8;
/// decimals > kMostDecimals: printed with an exponent.
constexpr int kMostDecimals = 9;

}  // namespace comparing
}  // namespace veridyn
