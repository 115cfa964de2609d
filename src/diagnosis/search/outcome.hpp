#pragma once

#include "diagnosis/search/options.hpp"
#include "diagnosis/search/present.hpp"

namespace veridyn::search {

/// Gain of each term of the final set next to all others, with deviations, rivals and held-out errors, and
/// the terms that were refused. Moves the terms out of the set.
SearchResult outcome_of(Present& at, Options& options, const SearchRequest& request);

}  // namespace veridyn::search
