#pragma once

#include <vector>

namespace veridyn {

/// In which cycles of the loop samples of force sensors are taken, as a pattern that repeats.
struct SamplePattern {
  int cycles = 1;              ///< after which it repeats
  std::vector<double> ratios;  ///< (sensors) samples per cycle; 1 for sensors that are faster
};

/// The pattern of sensors with these samples per cycle. Ratios are exact where their own pattern has at
/// most 24 cycles, or is one sample in a whole number of cycles; else the nearest such ratio. Where the
/// common pattern of several sensors would be longer than 1000 cycles, ratios are rounded to whole samples
/// in a multiple of the slowest sensor's pattern below that.
/// @throws InvalidInput  a sensor has less than one sample in 1000 cycles.
SamplePattern sample_pattern(const std::vector<double>& samples_per_cycle);

}  // namespace veridyn
