#pragma once

#include <functional>

#include "veridyn/recordings/preprocessing.hpp"

namespace veridyn {

using VisitSegment = std::function<void(const Segment&)>;
using StretchPass = std::function<PreparationFacts(const VisitSegment&)>;

/// A pass over a recording whose reading and preparation run in a separate thread, at most two
/// segments ahead of `visit`. Exceptions of either side are rethrown here.
PreparationFacts read_ahead(const StretchPass& pass, const VisitSegment& visit);

}  // namespace veridyn
