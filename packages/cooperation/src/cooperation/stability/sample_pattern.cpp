#include "sample_pattern.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr long kOwnPattern = 24;        // [cycles] longest sampling pattern of one sensor
constexpr long kLongestPattern = 1000;  // [cycles] longest common period of all sensors' sampling patterns

struct Fraction {
  long above = 1, below = 1;
};

// The nearest ratio with a short pattern, see sample_pattern(); throws InvalidInput if it is too small.
Fraction nearby_fraction(double ratio) {
  if (ratio >= 1.0) return {};
  if (ratio * kOwnPattern < 1.0) {
    const double cycles = std::round(1.0 / ratio);
    require(cycles <= kLongestPattern, "found a force sensor with one sample in ", cycles,
            " cycles of the loop, expected at most ", kLongestPattern, " cycles between two samples.");
    return {1, static_cast<long>(cycles)};
  }
  Fraction best;
  double error = std::numeric_limits<double>::infinity();
  for (long below = 1; below <= kOwnPattern; ++below) {
    const long above = std::max(1L, std::lround(ratio * static_cast<double>(below)));
    const double off =
        std::abs(static_cast<double>(above) / static_cast<double>(below) - ratio);
    if (off < error - 1e-12) {
      error = off;
      best = {above, below};
    }
  }
  return best;
}

}  // namespace

SamplePattern sample_pattern(const std::vector<double>& samples_per_cycle) {
  std::vector<Fraction> all;
  long cycles = 1;
  Fraction slowest;
  for (const double ratio : samples_per_cycle) {
    const Fraction one = nearby_fraction(ratio);
    if (cycles <= kLongestPattern) cycles = std::lcm(cycles, one.below);
    if (one.above * slowest.below < slowest.above * one.below) slowest = one;
    all.push_back(one);
  }
  if (cycles > kLongestPattern) {
    cycles = kLongestPattern / slowest.below * slowest.below;
    for (Fraction& one : all) {
      const double ratio = static_cast<double>(one.above) / static_cast<double>(one.below);
      one = {std::max(1L, std::lround(ratio * static_cast<double>(cycles))), cycles};
    }
  }
  SamplePattern out;
  out.cycles = static_cast<int>(cycles);
  for (const Fraction& one : all)
    out.ratios.push_back(static_cast<double>(one.above) / static_cast<double>(one.below));
  return out;
}

}  // namespace veridyn
