#pragma once

#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Share of the mean square of what an arm at rest leaves of a joint's torque in training poses that smooth functions of
/// the positions, alone and in pairs, predict on poses that are held out; 0: none does.
double predicted_by_positions(const Identification& at_rest, int joint, const Thresholds& limits);

}  // namespace veridyn
