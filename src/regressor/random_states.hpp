#pragma once

#include <string>
#include <vector>

#include "veridyn/math/motion_samples.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// States all over the limits of an arm, the same on every machine for a seed: what a regressor is
/// asked at when it is about the arm and not about a motion. Accelerations reach five times the
/// largest speed per second. Joints without limits move within 1 rad or 0.1 m.
/// @param still  names of coordinates that stay in the middle of their range, at rest.
MotionSamples random_states(const Model& arm, int count, unsigned seed = 7,
                            const std::vector<std::string>& still = {});

/// How many of them a choice among so many columns needs.
int state_count(int columns, int joints);

}  // namespace veridyn
