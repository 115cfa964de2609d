#pragma once

#include <string>
#include <vector>

#include "diagnosis/findings/contacts.hpp"
#include "diagnosis/search/rows.hpp"

namespace veridyn::search {

/// Adds the intervals of half a second or more in which a residual (rows x n) keeps one sign, as under a
/// push. A push is rare: nothing is added for a recording in which the residual keeps its sign for a large
/// part of the time, nor a moment that comes back with the period of the motion.
/// @param scale    (n) scale of the residual [N m] or [N].
/// @param sources  the recordings of the rows. @param periods  [s] of their motions; 0: no repetition.
void add_moments_in(const Rows& rows, const MatrixXd& residual, const VectorXd& scale, const std::vector<std::string>& sources,
                    const std::vector<double>& periods, std::vector<Contact>& out);

}  // namespace veridyn::search
