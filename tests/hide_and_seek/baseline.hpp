#pragma once

#include <string>
#include <vector>

#include "hide_and_seek/judge.hpp"

namespace veridyn::seek {

/// A baseline without a diagnosis: least squares with one effect added on one joint, for every
/// effect and joint. The effect that lowers its joint's sum of squares on the training recordings
/// most is named, if by 2 % or more. Shape constants keep their initial values; errors of sensors
/// and geometry are not tested.
std::vector<NamedFinding> named_by_least_squares(const Model& robot,
                                                 const std::vector<std::string>& train, int threads);

}  // namespace veridyn::seek
