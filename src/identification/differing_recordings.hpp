#pragma once

#include <string>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// A sentence on training recordings that differ from the others, for example by another load; empty if none
/// does. On a recording, the error of the common parameters is compared with that of the recording's own ones;
/// this ratio is normal if it is near that between the recording and its halves.
/// @param id  with factors and errors of the training recordings.
std::string differing_recordings(const Model& arm, const Identification& id);

/// A sentence on recordings, of training or held out, in which a model leaves far more than its noise floor on a joint that it
/// explains in another one; or empty.
/// @param evaluated  errors of a given model, of which nothing was fitted.
std::string recordings_apart(const Identification& evaluated);

}  // namespace veridyn
