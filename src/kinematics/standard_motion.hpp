#pragma once

#include "veridyn/math/motion_samples.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// A motion that depends on the arm's limits only, as a reference for sizes of effects and differences
/// between models: 30 s at 100 Hz, with one sine for each joint around the middle of its range, at 0.2 Hz
/// plus 0.07 Hz for every further joint, over at most 70 % of the range, half the speed and 90 % of the
/// acceleration (limits of motion_limits()).
MotionSamples standard_motion(const Model& arm);

/// Frequency [Hz] of a joint's sine; joints are counted from 0.
double standard_frequency(int joint);

}  // namespace veridyn
