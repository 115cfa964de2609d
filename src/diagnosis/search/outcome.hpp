#pragma once

#include "diagnosis/search/exchanges.hpp"
#include "diagnosis/search/current_set.hpp"

namespace veridyn::search {

/// Gain of each term of the final set next to all others, with deviations, rivals and held-out errors, and
/// the terms that were rejected. Moves the terms out of the set.
SearchResult outcome_of(CurrentSet& at, Exchanges& exchanges, const SearchRequest& request);

}  // namespace veridyn::search
