#pragma once

#include "diagnosis/search/options.hpp"
#include "diagnosis/search/present.hpp"

namespace veridyn::search {

/// What the terms of the final set gain beside all others, with their deviations, rivals and held-out errors, and what did
/// not enter. Takes the terms of the set.
SearchResult outcome_of(Present& at, Options& options, const SearchRequest& request);

}  // namespace veridyn::search
