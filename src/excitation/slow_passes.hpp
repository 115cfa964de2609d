#pragma once

#include <functional>
#include <vector>

#include "kinematics/motion_limits.hpp"
#include "veridyn/math/motion_samples.hpp"

namespace veridyn {

/// One joint after the other leaves a pose at a slow, constant speed, returns, and repeats this
/// once, with a reversal at either end: such passes excite friction at low speed and around
/// reversals, which a Fourier series passes quickly.
///
/// The speeds of a joint's passes are spread logarithmically from 1 to 10 % of its largest one. A
/// outward motion lasts 3 s, less where the range is too short.
///
/// @param limits  of positions, speeds and accelerations.
/// @param rest    (n) pose at the beginning and the end.
/// @param joints  joints to move, from 0.
/// @param passes  number of passes of each, each with a speed of its own.
/// @param keeps   true if a motion keeps all other limits; if not, the displacement is halved, and
/// the pass is omitted if that does not help.
/// @returns samples at `rate` [Hz], time from zero; no rows where nothing is possible.
MotionSamples slow_passes(const MotionLimits& limits, const VectorXd& rest,
                          const std::vector<int>& joints, int passes, double rate,
                          const std::function<bool(const MotionSamples&)>& keeps);

/// Concatenates motions; the first row of the second equals the last row of the first.
MotionSamples joined(const MotionSamples& first, const MotionSamples& second);

}  // namespace veridyn
