#pragma once

#include <memory>
#include <vector>

#include "regressor/column_source.hpp"

namespace veridyn {

/// Bodies and effects of an arm, in this order: the columns of standard_parameters().
/// @param rounding  speeds, as a share of each joint's largest, within which columns that jump with
///                  the sign of a velocity are rounded off; 0: the columns as they are.
std::vector<std::shared_ptr<const ColumnSource>> arm_columns(const Model& arm, double rounding);

}  // namespace veridyn
