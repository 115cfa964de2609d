#pragma once

#include <memory>
#include <vector>

#include "regressor/column_source.hpp"

namespace veridyn {

/// Bodies and effects of an arm, in this order: the columns of standard_parameters().
/// @param rounding  share of each joint's largest speed within which the sign of the velocity is
/// smoothed; 0: unmodified columns.
std::vector<std::shared_ptr<const ColumnSource>> arm_columns(const Model& arm, double rounding);

}  // namespace veridyn
