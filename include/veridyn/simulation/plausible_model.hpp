#pragma once

#include "veridyn/model/model.hpp"

namespace veridyn {

/// An arm with values that could be those of a real one where its robot file gives none.
struct PlausibleModel {
  Model arm;
  int bodies = 0;   ///< Number of those that got values
  int effects = 0;  ///< Number of those that got values
};

/// Bodies are ellipsoids of 0.2 to 3 kg with half axes of 3 to 12 cm, turned at random, their
/// centre within 0.1 m of the frame's origin in every direction (and within the file's box).
/// Effects each get 10 % of the rms effort along their axis over a standard motion of the arm, see
/// inject_effects(); of 0.1 N m or N where it is smaller (joints that no body loads). The same arm and seed give the same values.
PlausibleModel plausible_model(const Model& arm, unsigned seed);

}  // namespace veridyn
