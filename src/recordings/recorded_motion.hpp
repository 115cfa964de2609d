#pragma once

#include <string>
#include <vector>

#include "veridyn/math/motion_samples.hpp"
#include "veridyn/model/model.hpp"
#include "veridyn/recordings/preprocessing.hpp"

namespace veridyn {

/// How an arm moved in a recording. Accelerations are those of the file where it has them (a motion
/// that was designed); otherwise positions and velocities are low-passed and differentiated as for
/// an identification, one motion for every stretch without a gap.
///
/// @param how  how the file is read (columns, rate, signals), and which of its rows count.
/// @throws InvalidInput  the file is bad, or is not of an arm with so many joints.
std::vector<MotionSamples> recorded_motion(const Model& arm, const std::string& path,
                                           const PreprocessingOptions& how = {});

}  // namespace veridyn
