#pragma once

#include <string>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// A sentence on training recordings that differ from the others, for example by another load; empty if none
/// does. On a recording, the error of the common parameters is compared with that of the recording's own ones;
/// this ratio is normal if it is near that between the recording and its halves.
/// @param id  with factors and errors of the training recordings.
std::string differing_recordings(const Model& arm, const Identification& id);

}  // namespace veridyn
