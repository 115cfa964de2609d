#pragma once

#include <string>
#include <vector>

#include "hide_and_seek/bench.hpp"

namespace veridyn::seek {

/// Every joint, pair of joints, frame or constant of the arm where an effect could be hidden;
/// joints that have a cause already are left out. Causes without values.
std::vector<Cause> places_for(const std::string& effect, const Bench& bench,
                              const std::vector<Cause>& taken);

/// True for friction and offsets that the robot files of the bench declare.
bool is_declared(const std::string& effect);

/// A robot file that does not know of the friction that is hidden, and an arm without other such
/// friction on that joint.
void forget_friction(Bench& bench, const Cause& cause);

}  // namespace veridyn::seek
