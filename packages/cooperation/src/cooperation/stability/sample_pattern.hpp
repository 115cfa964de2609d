#pragma once

#include <vector>

namespace veridyn {

/// The cycles of the loop in which force sensors take samples, as a pattern that repeats.
struct SamplePattern {
  int cycles = 1;              ///< length of the pattern
  std::vector<double> ratios;  ///< (sensors) samples per cycle; 1 for sensors that are faster
};

/// The pattern of sensors with these samples per cycle. A ratio is exact if its own pattern has at most 24
/// cycles, or if it is one sample in an integer number of cycles; else it is the nearest such ratio. If the
/// common pattern of several sensors would be longer than 1000 cycles, ratios are rounded to integer numbers
/// of samples in a shorter multiple of the slowest sensor's pattern.
/// @throws InvalidInput  a sensor has less than one sample in 1000 cycles.
SamplePattern sample_pattern(const std::vector<double>& samples_per_cycle);

}  // namespace veridyn
