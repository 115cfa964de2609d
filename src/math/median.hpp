#pragma once

#include <algorithm>
#include <vector>

namespace veridyn {

/// The upper one of two middle values; zero of nothing.
template <typename Number>
Number median(std::vector<Number> values) {
  if (values.empty()) return Number(0);
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace veridyn
