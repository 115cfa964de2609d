#pragma once

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// An arm whose rotors all have inertia enough to be moved.
struct MovableArm {
  Model arm;
  std::vector<std::string> changed;  ///< what was changed, a sentence each
};

/// Identification that keeps a rotor's inertia from being negative leaves it at zero where the data
/// would rather have less. An axis that nothing else loads could not be simulated then: forces
/// without inertia. Rotors below a tenth of their own standard deviation get that tenth, which the
/// data cannot tell from what they had. Those without a standard deviation stay.
MovableArm with_movable_rotors(const Model& arm);

}  // namespace veridyn
