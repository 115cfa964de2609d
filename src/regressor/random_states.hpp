#pragma once

#include <string>
#include <vector>

#include "veridyn/math/motion_samples.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Random states within the limits of an arm, equal on every machine for a seed: they represent the
/// arm independently of a motion. Accelerations reach five times the largest speed per second.
/// Joints without limits move within 1 rad or 0.1 m.
/// @param still  names of coordinates that are held at rest in the middle of their range.
MotionSamples random_states(const Model& arm, int count, unsigned seed = 7,
                            const std::vector<std::string>& still = {});

/// Number of random states that suffices for a choice among this many columns.
int state_count(int columns, int joints);

}  // namespace veridyn
