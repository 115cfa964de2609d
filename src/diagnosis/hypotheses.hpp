#pragma once

#include <string>
#include <vector>

#include "veridyn/identification/compressed_recording.hpp"

namespace veridyn {

/// One thing that may be missing in the model: an effect on one coordinate with one choice of its
/// shape constants.
struct Hypothesis {
  std::string effect;
  int joint = 0;  ///< coordinate, from 0
  int term = 0;   ///< index among the augmented model's effects
  std::vector<std::string> columns;
  std::vector<ParameterSign> signs;
  int stage =
      0;  ///< order of the questions: 0 channels, 1 inertia and elasticity, 2 friction and forces
  std::string family;  ///< hypotheses that differ in shape constants only share it
};

/// The arm with one more effect for every hypothesis; the effects' columns then come out of the
/// same pass as all others.
struct AugmentedModel {
  Model model;
  std::vector<Hypothesis> hypotheses;
};

/// @param arm     with values, so that effects that depend on the load have one.
/// @param facts   of the training recordings: ranges of motion, for grids of lengths and speeds.
/// @param wanted  names of effects; empty: all.
AugmentedModel augmented_model(const Model& arm, const std::vector<CompressedRecording>& facts,
                               const std::vector<std::string>& wanted);

}  // namespace veridyn
