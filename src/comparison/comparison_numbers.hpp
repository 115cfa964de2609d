#pragma once

/// All numbers that can change what `compare` says, each with its inequality, and with its
/// reason where one is known.
namespace veridyn::comparison_numbers {

/// |difference| <= kSameToRounding * the larger one counts as a deviation: rounding in files, and the
/// discretisation of a noise-free recording.
constexpr double kSameToRounding = 1e-6;
/// probability outside of an interval = kOutside.
constexpr double kOutside = 0.05;
/// fourth moment of a normal distribution = kKurtosis of its squared variance, less what equal clusters
/// would give by chance.
constexpr double kKurtosis = 3.0;
/// share of a parameter's rms torque < kRoundedAway: due to the grid of samples, and zero.
constexpr double kRoundedAway = 5e-3;
/// time < end of the last whole period - kSameTime [s]: it counts.
constexpr double kSameTime = 1e-9;
/// relative error of a file's base parameters <= kFromValues: they are those of its values.
constexpr double kFromValues = 1e-6;
/// distance of two motions < kSameMotion of their spread over clusters: one motion, compared in pairs.
constexpr double kSameMotion = 0.2;
/// part of a combination outside the span <= kInSpan: the other model determines it.
constexpr double kInSpan = 1e-5;
/// relative difference of shape constants <= kLike: effects are comparable.
constexpr double kLike = 0.2;
/// |a - b| <= kSame * (1 + |a|): equal; what files lose in rounding is less.
constexpr double kSame = 1e-9;
/// share of a column's rms due to weight > kWeightShare: a sentence mentions it.
constexpr double kWeightShare = 0.05;
/// torque on another joint >= kAlsoOn of the largest: a sentence mentions it.
constexpr double kAlsoOn = 0.2;
/// value before > kSurelyThere deviations: a percentage is printed.
constexpr double kSurelyThere = 3.0;
/// digits of a value without a deviation >= those of kDigits of it.
constexpr double kDigits = 1e-3;
/// differences of a list that are printed <= kListed.
constexpr int kListed = 8;
/// decimals > kMostDecimals: printed with an exponent.
constexpr int kMostDecimals = 9;

}  // namespace veridyn::comparison_numbers
