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

/// The forces in the places where simulators store them: at joints, at tendons, or in motors.
struct PlacedEffects {
  std::vector<SimpleForce> along;   ///< one force per coordinate, converted to that coordinate
  std::vector<SimpleForce> across;  ///< along several coordinates at once
  VectorXd constants;               ///< constant per coordinate; constants of springs are in the springs
};

/// @param joints  number of the arm's coordinates.
PlacedEffects placed_effects(const std::vector<SimpleForce>& forces, int joints);

/// The effects of an arm, divided by their traits and columns, without their names.
KnownEffects known_effects(const Model& arm);

}  // namespace veridyn
