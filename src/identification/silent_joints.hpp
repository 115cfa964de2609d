#pragma once

#include <set>
#include <vector>

#include "veridyn/identification/compressed_recording.hpp"

namespace veridyn {

/// Joints, from 0, whose torque is zero throughout all of these recordings: it was not recorded, or nothing drove them.
std::set<int> silent_joints(const std::vector<CompressedRecording>& recordings);

/// The rows of every joint in every recording that has no torque of it: unmeasured zeros are no torques.
std::vector<ExcludedInterval> silent_rows(const std::vector<CompressedRecording>& recordings);

/// The arm without effects that act on these joints alone, whose parameters are undetermined.
Model without_effects_of(const std::set<int>& joints, const Model& arm);

/// Empties the factors of these joints: unmeasured zeros are no torques.
void exclude_joints(const std::set<int>& joints, std::vector<CompressedRecording>& recordings);

}  // namespace veridyn
