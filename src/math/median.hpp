#pragma once

#include <algorithm>
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

}  // namespace veridyn
