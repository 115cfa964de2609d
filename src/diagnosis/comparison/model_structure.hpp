#pragma once

#include <string>
#include <vector>

#include "veridyn/diagnosis/model_comparison.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// @throws InvalidInput  coordinates, frames or bodies differ: the models describe two different robots.
void require_one_arm(const Model& before, const Model& after);

/// The arm without the frames that the other model does not have; these are fixed to others, as that of a
/// diagnosed load is. Their bodies are added to the bodies that carry them, which changes no torque and keeps
/// the statistics of an identification.
/// @throws InvalidInput  such a body has no values, or is fixed to a frame without a body.
Model without_frames_of_its_own(const Model& arm, const Model& other);

/// Differences of effects, shapes, constants, gravity, drive gains and known values.
std::vector<StructureDifference> structure_differences(const Model& before, const Model& after);

/// Names of all standard parameters of both models, with equal names where parameters correspond. Names do
/// not contain the values of shape constants: effects of one kind on one axis are numbered by the order of
/// their constants. Bodies with different frames do not correspond, nor do effects with a constant that
/// differs by more than half.
struct MatchingNames {
  std::vector<std::string> before, after;
};
MatchingNames matching_names(const Model& before, const Model& after);

}  // namespace veridyn
