#pragma once

#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

constexpr double kIndependent = 1e-6;

/// Columns of W that span all of them: each time the one of which most is left (columns count as of
/// norm one), the first of equals in the given order.
/// @param taken  columns that count as there already; they are not among the result.
/// @param least  what must be left of a column of norm one; below 1e-6 is rounding.
std::vector<int> independent_columns(const MatrixXd& W, const std::vector<int>& order,
                                     const std::vector<int>& taken = {},
                                     double least = kIndependent);

/// Swaps columns until no single swap makes the volume of the chosen ones, of norm one, larger:
/// about the best conditioned choice (Gu and Eisenstat, SIAM J. Scientific Computing 17(4), 1996).
void improve_choice(const MatrixXd& W, std::vector<int>& chosen);

}  // namespace veridyn
