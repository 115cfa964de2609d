#pragma once

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// A force along one axis s = c . q that simulators can represent:
///
///   force = offset + stiffness s + damping ds + inertia dds + friction sign(ds)
struct SimpleForce {
  Axis axis;
  double offset = 0.0, stiffness = 0.0, damping = 0.0, inertia = 0.0, friction = 0.0;
};

/// Effects of an arm, divided into such forces and others.
struct KnownEffects {
  std::vector<SimpleForce> forces;    ///< sums of effects along each axis
  std::vector<std::string> left_out;  ///< the other effects, in words
};

/// Forces as simulators attach them.
struct PlacedEffects {
  std::vector<SimpleForce> along;   ///< by coordinate, scaled to its own axis
  std::vector<SimpleForce> across;  ///< along several coordinates at once
  VectorXd constants;               ///< by coordinate; those of springs are in the springs
};

/// @param joints  number of the arm's coordinates.
PlacedEffects placed_effects(const std::vector<SimpleForce>& forces, int joints);

/// Determined by the traits and columns of the effects, without using their names.
KnownEffects known_effects(const Model& arm);

}  // namespace veridyn
