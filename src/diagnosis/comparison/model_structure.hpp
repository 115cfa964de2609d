#pragma once

#include <string>
#include <vector>

#include "veridyn/diagnosis/model_comparison.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// @throws InvalidInput  coordinates, frames or bodies differ, so that these are two robots.
void require_one_arm(const Model& before, const Model& after);

/// The arm without frames that the other model lacks, which are fixed to others, such as a
/// diagnosed load: their bodies become part of those that carry them, which changes no torque.
/// Statistics of an identification keep their values.
/// @throws InvalidInput  such a body has no values, or hangs on a frame without a body.
Model without_frames_of_its_own(const Model& arm, const Model& other);

/// Effects, shapes, constants, gravity, drive gains and facts that differ.
std::vector<StructureDifference> structure_differences(const Model& before, const Model& after);

/// Names of all standard parameters of both models, equal where parameters correspond. They do not
/// depend on the values of shape constants: an effect that occurs twice on one axis is numbered in
/// the order of its constants. Bodies do not correspond where frames differ, effects where a
/// constant differs by more than half.
struct MatchingNames {
  std::vector<std::string> before, after;
};
MatchingNames matching_names(const Model& before, const Model& after);

}  // namespace veridyn
