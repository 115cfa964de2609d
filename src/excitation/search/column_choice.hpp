#pragma once

#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

constexpr double kIndependent = 1e-6;

/// Columns of W that span all of them, by pivoting: the next column is the one with the largest remainder
/// (columns scaled to norm one), among equals the first in the given order.
/// @param taken  columns that are already chosen; not part of the result.
/// @param least  smallest remainder of a column of norm one; below 1e-6 it is rounding.
std::vector<int> independent_columns(const MatrixXd& W, const std::vector<int>& order,
                                     const std::vector<int>& taken = {},
                                     double least = kIndependent);

/// Swaps columns until no single swap increases the volume of the chosen ones, of norm one: nearly
/// the best-conditioned choice (Gu and Eisenstat, SIAM J. Scientific Computing 17(4), 1996).
void improve_choice(const MatrixXd& W, std::vector<int>& chosen);

}  // namespace veridyn
