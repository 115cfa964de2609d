#pragma once

#include <algorithm>
#include <type_traits>
#include <utility>
#include <vector>

namespace veridyn {

/// Upper median: the larger one of two middle values; zero for an empty list.
template <typename Number>
Number median(std::vector<Number> values) {
  if (values.empty()) return Number(0);
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Ratio of the standard deviation of a normal distribution to its median absolute deviation.
constexpr double kMadToDeviation = 1.4826;

/// The median step from one time to the next; zero for fewer than two times.
template <typename Times>
auto median_step(const Times& time) {
  std::vector<std::decay_t<decltype(time[0])>> steps;
  for (decltype(time.size()) k = 1; k < time.size(); ++k) steps.push_back(time[k] - time[k - 1]);
  return median(std::move(steps));
}

}  // namespace veridyn
