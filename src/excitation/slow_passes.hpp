#pragma once

#include <functional>
#include <vector>

#include "kinematics/motion_limits.hpp"
#include "veridyn/math/motion_samples.hpp"

namespace veridyn {

/// One joint after the other leaves a pose at a slow, constant speed, comes back, goes and comes
/// back once more, with a reversal at either end: what friction does at low speed and around
/// reversals, which a Fourier series passes over in no time.
///
/// The speeds of a joint's passes are spread evenly in the logarithm from 1 to 10 % of its largest
/// one. A way out lasts 3 s, less where there is no room for it.
///
/// @param limits  of positions, speeds and accelerations.
/// @param rest    (n) where all of it begins and ends.
/// @param joints  which of them, from 0.
/// @param passes  of every one of these, each with a speed of its own.
/// @param keeps   whether a motion is within all other limits; where it is not, the way is halved,
///                and the pass is left out where that does not help.
/// @returns samples at `rate` [Hz], time from zero; no rows where nothing is possible.
MotionSamples slow_passes(const MotionLimits& limits, const VectorXd& rest,
                          const std::vector<int>& joints, int passes, double rate,
                          const std::function<bool(const MotionSamples&)>& keeps);

/// One motion after the other; the first row of the second is where the first one ends.
MotionSamples joined(const MotionSamples& first, const MotionSamples& second);

}  // namespace veridyn
