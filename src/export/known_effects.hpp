#pragma once

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// What simulators have words for, along one axis s = c . q:
///
///   force = offset + stiffness s + damping ds + inertia dds + friction sign(ds)
struct SimpleForce {
  Axis axis;
  double offset = 0.0, stiffness = 0.0, damping = 0.0, inertia = 0.0, friction = 0.0;
};

/// Effects of an arm, as far as they are such forces.
struct KnownEffects {
  std::vector<SimpleForce> forces;    ///< effects along one axis added up
  std::vector<std::string> left_out;  ///< the others, in words
};

/// Forces as simulators take them.
struct PlacedEffects {
  std::vector<SimpleForce> along;   ///< by coordinate, whatever their factors were; no axis
  std::vector<SimpleForce> across;  ///< along several coordinates at once
  VectorXd constants;               ///< by coordinate; those of springs stay with them
};

/// @param joints  number of the arm's coordinates.
PlacedEffects placed_effects(const std::vector<SimpleForce>& forces, int joints);

/// What the effects' own traits and columns say; no effect is known by its name.
KnownEffects known_effects(const Model& arm);

}  // namespace veridyn
