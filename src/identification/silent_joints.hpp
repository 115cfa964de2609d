#pragma once

#include <set>
#include <vector>

#include "veridyn/identification/compressed_recording.hpp"

namespace veridyn {

/// Joints, from 0, whose torque is zero in all of these recordings: it was not recorded, or nothing drove the
/// joint.
std::set<int> silent_joints(const std::vector<CompressedRecording>& recordings);

/// For every recording, all rows of the joints without torque in it, to be excluded.
std::vector<ExcludedInterval> silent_rows(const std::vector<CompressedRecording>& recordings);

/// The arm without the effects that act on these joints alone, whose parameters are undetermined.
Model without_effects_of(const std::set<int>& joints, const Model& arm);

/// Empties the factors of these joints.
void exclude_joints(const std::set<int>& joints, std::vector<CompressedRecording>& recordings);

}  // namespace veridyn
