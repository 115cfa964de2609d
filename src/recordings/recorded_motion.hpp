#pragma once

#include <string>
#include <vector>

#include "veridyn/math/motion_samples.hpp"
#include "veridyn/model/model.hpp"
#include "veridyn/recordings/preprocessing.hpp"

namespace veridyn {

/// The motion of an arm in a recording, in one part for every segment without a gap. Accelerations come from
/// the file if it has them (a designed motion); otherwise positions and velocities are low-passed and
/// differentiated as for an identification.
///
/// @param how  options for reading the file (columns, rate, signals) and for selecting its rows.
/// @throws InvalidInput  the file is bad, or its number of joints differs from the arm's.
std::vector<MotionSamples> recorded_motion(const Model& arm, const std::string& path,
                                           const PreprocessingOptions& how = {});

/// @throws InvalidInput  a recording has another number of joints than the arm; the message names the option that helps.
void require_joints_of(const Model& arm, int found, const std::string& recording);

}  // namespace veridyn
