#pragma once

#include <string>
#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Groups of two or more collinear columns, whose correlation with the first of the group is above
/// `least` in magnitude. Rows with NaN and nearly constant columns are ignored.
std::vector<std::vector<int>> correlated_columns(const MatrixXd& values, double least = 0.999);

/// Text of indices, counted from 1: "1, 3 and 4".
std::string numbers_from_one(const std::vector<int>& indices);

}  // namespace veridyn
