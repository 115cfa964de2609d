#pragma once

#include <cstddef>

namespace veridyn {

/// All numbers that can change the result of `fleet`. Each comment gives the condition, then its consequence,
/// and the reason where one is known.
struct FleetNumbers {
  /// number of arms that identify a quantity >= fewest, else none is compared: of two it is unknown which one
  /// is the outlier.
  int fewest = 3;
  /// |value - median| > noticeable * |median|, else not reported, however narrow the fleet is (an
  /// argument, not measured).
  double noticeable = 0.02;
  /// number of rounds that update weights, gains and outliers = rounds; the last one excludes the outliers
  /// found before.
  int rounds = 4;
  /// groups of arms for the deviations of the bodies <= groups (not measured).
  int groups = 64;
  /// degrees of freedom of robust deviations <= most_freedom: parameters of a fleet scatter with heavier tails than a
  /// normal distribution has.
  double most_freedom = 30.0;
  /// share of a column's norm outside the span of the others < least_independent_share: its value is undetermined.
  double least_independent_share = 1e-6;
  /// quantities of one kind < fewest_spreads: no prior of their spreads.
  int fewest_spreads = 4;
  /// degrees of freedom of that prior <= most_prior: the arms' own spread still counts.
  double most_prior = 8.0;
  /// decrease of the squared residual by an arm's own bodies > least_excess, else its bodies are those of the
  /// fleet.
  double least_excess = 0.02;
  /// ridge of an own column = own_ridge * its norm: without data it is zero; of a gain = gain_ridge * its
  /// norm: the mean gain is one, which fixes the common scale of bodies and gains.
  double own_ridge = 1e-7;
  double gain_ridge = 1e-3;
};

/// Numbers that change no result: constants of statistics, accuracies, and lengths of lists.
namespace fleets {

constexpr FleetNumbers numbers;

/// degrees of freedom = kEfficiency * (arms - 1): efficiency of the median deviation relative to the
/// standard deviation (Rousseeuw and Croux, JASA 88(424), 1993).
constexpr double kEfficiency = 0.37;
/// robust deviation of FittedArm::excess >= kLeastSpread, so that equal arms cause no division by zero.
constexpr double kLeastSpread = 1e-6;
/// bisection of the prior's degrees of freedom ends at a width < kWidth.
constexpr double kWidth = 1e-3;
/// entries of a list in the text <= kShown; the JSON has all.
constexpr std::size_t kShown = 20;
/// progress = kReading when all arms are read.
constexpr double kReading = 0.9;

}  // namespace fleets
}  // namespace veridyn
