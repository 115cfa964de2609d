#pragma once

#include <cstddef>

/// All numbers that can change what `fleet` says, each with its inequality, and with its reason where
/// one is known.
namespace veridyn::fleet_numbers {

/// arms of a quantity >= kFewest, else nobody is compared: of two nobody knows which one is odd.
constexpr int kFewest = 3;
/// |value - median| > kNoticeable * |median|, else not reported, however narrow the fleet is (an
/// argument, not measured).
constexpr double kNoticeable = 0.02;
/// rounds of weights, gains and odd arms = kRounds; the last one leaves out those found before.
constexpr int kRounds = 4;
/// groups of arms for the deviations of the bodies <= kGroups (not measured).
constexpr int kGroups = 64;
/// degrees of freedom of robust deviations <= kFreedom: fleets have heavier tails than a normal
/// distribution.
constexpr double kFreedom = 30.0;
/// degrees of freedom = kEfficiency * (arms - 1): efficiency of the median deviation relative to the
/// standard deviation (Rousseeuw and Croux, JASA 88(424), 1993).
constexpr double kEfficiency = 0.37;
/// share of a column's norm outside the span of the others < kTelling: its value means nothing.
constexpr double kTelling = 1e-6;
/// quantities of one kind < kFewestSpreads: no prior of their spreads.
constexpr std::size_t kFewestSpreads = 4;
/// degrees of freedom of that prior <= kMostPrior: the arms' own spread still counts.
constexpr double kMostPrior = 8.0;
/// fall of the squares by an arm's own bodies > kLeastExcess, else its bodies are those of the fleet.
constexpr double kLeastExcess = 0.02;
/// spread of these falls >= kLeastSpread, so that equal arms divide by no zero.
constexpr double kLeastSpread = 1e-6;
/// ridge of an own column = kOwnRidge * its norm: without data it is zero; of a gain = kGainRidge * its
/// norm: the mean gain is one, which fixes the common scale of bodies and gains.
constexpr double kOwnRidge = 1e-7;
constexpr double kGainRidge = 1e-3;
/// bisection of the prior's degrees of freedom ends at a width < kWidth.
constexpr double kWidth = 1e-3;
/// entries of a list in the text <= kShown; the JSON has all.
constexpr std::size_t kShown = 20;
/// progress = kReading when all arms are read.
constexpr double kReading = 0.9;

}  // namespace veridyn::fleet_numbers
