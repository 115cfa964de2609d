#pragma once

#include <string>
#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Groups of two or more columns that are straight lines of one another: whose correlation with the
/// first of the group is above `least` in size. Rows with NaN and columns that hardly change do not
/// count.
std::vector<std::vector<int>> correlated_columns(const MatrixXd& values, double least = 0.999);

/// "1, 3 and 4" of numbers from 0.
std::string numbers_from_one(const std::vector<int>& indices);

}  // namespace veridyn
