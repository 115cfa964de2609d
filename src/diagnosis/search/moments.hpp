#pragma once

#include <string>
#include <vector>

#include "diagnosis/findings/contacts.hpp"
#include "diagnosis/search/rows.hpp"

namespace veridyn::search {

/// Adds the stretches of half a second and more in which a residual (rows x n) keeps one sign: something pushed or held the
/// arm. A push is rare: of a recording whose residual keeps its sign for a large part of its time nothing is added.
/// @param scale    (n) of the residual [N m] or [N].
/// @param sources  the recordings of the rows.
void add_moments_in(const Rows& rows, const MatrixXd& residual, const VectorXd& scale, const std::vector<std::string>& sources,
                    std::vector<Contact>& out);

}  // namespace veridyn::search
