#pragma once

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// An arm in which every rotor has some inertia.
struct MovableArm {
  Model arm;
  std::vector<std::string> changed;  ///< one sentence for each change
};

/// An identification with nonnegative rotor inertia yields zero where the data would prefer a
/// negative value. An axis with no other inertia could then not be simulated. Rotors below a tenth
/// of their own standard deviation are set to that tenth, which the data cannot distinguish from
/// the estimate. Those without a standard deviation are unchanged.
MovableArm with_movable_rotors(const Model& arm);

}  // namespace veridyn
