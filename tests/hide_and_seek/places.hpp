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

/// Removes the friction that is to be hidden from the robot file, and other friction of that kind on
/// that joint from the arm.
void forget_friction(Bench& bench, const Cause& cause);

}  // namespace veridyn::seek
