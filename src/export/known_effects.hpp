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

  /// The coordinate that the axis is, if it is one and nothing else; else -1.
  int coordinate() const;
};

/// Effects of an arm, as far as they are such forces.
struct KnownEffects {
  std::vector<SimpleForce> forces;    ///< effects along one axis added up
  std::vector<std::string> left_out;  ///< the others, in words
};

/// What the effects' own traits and columns say; no effect is known by its name.
KnownEffects known_effects(const Model& arm);

}  // namespace veridyn
