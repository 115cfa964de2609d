#pragma once

#include "veridyn/model/model.hpp"

namespace veridyn {

/// An arm whose missing values are replaced by plausible ones.
struct PlausibleModel {
  Model arm;
  int bodies = 0;   ///< number of bodies that were given values
  int effects = 0;  ///< number of effects that were given values
};

/// Gives an arm plausible values where it has none. Bodies are ellipsoids of 0.2 to 3 kg with half axes of 3 to
/// 12 cm, turned at random, their centre within 0.1 m of the frame's origin in every direction (and within the
/// file's box). Effects each get 10 % of the rms effort along their axis over a standard motion of the arm, see
/// inject_effects(); at least 10 % of 0.1 N m or N (joints that carry no body). The same arm and seed give the
/// same values.
PlausibleModel plausible_model(const Model& arm, unsigned seed);

}  // namespace veridyn
