#pragma once

#include <string>
#include <vector>

#include "hide_and_seek/judge.hpp"

namespace veridyn::seek {

/// What somebody does without a diagnosis: least squares with one effect added on one joint, for
/// every effect and joint. The one that takes away the most of its joint's sum of squares on the
/// training recordings is named, if that is 2 % or more. Constants that are no factors keep their
/// initial values; sensors and geometry are believed.
std::vector<NamedFinding> named_by_least_squares(const Model& robot,
                                                 const std::vector<std::string>& train, int threads);

}  // namespace veridyn::seek
