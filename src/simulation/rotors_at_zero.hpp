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

/// An arm in which rotors below a tenth of their own standard deviation are set to that tenth, which the data
/// cannot distinguish from the estimate. An identification with nonnegative rotor inertia yields zero if the
/// data would prefer a negative value, and an axis with no other inertia could not be simulated. Rotors without
/// a standard deviation are unchanged.
MovableArm with_movable_rotors(const Model& arm);

}  // namespace veridyn
