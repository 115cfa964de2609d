#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "math/digits.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

/// A combination of standard parameters in words, its leading parameter first: "m_tool + 0.25 m_counterweight".
///
/// @param row  coefficients of the standard parameters. @param names  their names.
inline std::string expression_of(const VectorRef& row, int leading, const std::vector<std::string>& names) {
  std::string out = names[leading];
  for (Eigen::Index j = 0; j < row.size(); ++j) {
    if (j == leading || row[j] == 0.0) continue;
    const std::string size = digits(std::abs(row[j]), 6);
    out += (row[j] < 0.0 ? " - " : " + ") + (size == "1" ? "" : size + " ") + names[j];
  }
  return out;
}

}  // namespace veridyn
