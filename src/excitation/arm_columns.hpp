#pragma once

#include <memory>
#include <vector>

#include "column_source.hpp"

namespace veridyn {

/// Bodies and effects of an arm, in this order.
/// @param rounding  as in BaseRegressor.
std::vector<std::shared_ptr<const ColumnSource>> arm_columns(const Model& arm, double rounding);

/// States all over the limits of an arm, the same every time.
MotionSamples random_states(const Model& arm, int count);

/// Effects, then what is not a mass, then the masses: as base parameters are commonly given.
std::vector<int> base_preference(int body_columns, int columns);

/// The first columns of W in the given order of which none follows from those before it
/// (Gram-Schmidt, twice for accuracy).
/// @param taken  columns that count as there already; they are not among the result.
std::vector<int> independent_columns(const MatrixXd& W, const std::vector<int>& order,
                                     const std::vector<int>& taken = {});

}  // namespace veridyn
