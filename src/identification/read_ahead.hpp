#pragma once

#include <functional>

#include "veridyn/recordings/preprocessing.hpp"

namespace veridyn {

using VisitStretch = std::function<void(const Stretch&)>;
using StretchPass = std::function<PreparationFacts(const VisitStretch&)>;

/// A pass over a recording whose reading and preparation run in a separate thread, at most two
/// segments ahead of `visit`. Exceptions of either side are rethrown here.
PreparationFacts read_ahead(const StretchPass& pass, const VisitStretch& visit);

}  // namespace veridyn
