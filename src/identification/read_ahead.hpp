#pragma once

#include <functional>

#include "veridyn/recordings/preprocessing.hpp"

namespace veridyn {

using VisitStretch = std::function<void(const Stretch&)>;
using StretchPass = std::function<PreparationFacts(const VisitStretch&)>;

/// A pass over a recording whose reading and preparing run in a thread of their own, at most two
/// stretches ahead of `visit`. What either side throws comes out here.
PreparationFacts read_ahead(const StretchPass& pass, const VisitStretch& visit);

}  // namespace veridyn
