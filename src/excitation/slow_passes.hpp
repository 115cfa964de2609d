#pragma once

#include <functional>
#include <vector>

#include "kinematics/motion_limits.hpp"
#include "veridyn/math/motion_samples.hpp"

namespace veridyn {

/// Each joint in turn moves away from a pose at a slow, constant speed and back, twice: such passes excite
/// friction at low speed and around reversals, which a Fourier series passes quickly.
///
/// The speeds of a joint's passes are spaced logarithmically from 1 to 10 % of its largest one. An outward
/// motion lasts 3 s, less if the range is too small.
///
/// @param limits  limits of positions, speeds and accelerations.
/// @param rest    (n) pose at the beginning and the end.
/// @param joints  joints to move, from 0.
/// @param passes  number of passes of each joint, each at another speed.
/// @param keeps   true if a motion is within all other limits; if not, the displacement is halved, and the
/// pass is omitted if that is not sufficient.
/// @returns samples at `rate` [Hz], time from zero; no rows if no pass is possible.
MotionSamples slow_passes(const MotionLimits& limits, const VectorXd& rest,
                          const std::vector<int>& joints, int passes, double rate,
                          const std::function<bool(const MotionSamples&)>& keeps);

/// Concatenates motions; the first row of the second equals the last row of the first.
MotionSamples joined(const MotionSamples& first, const MotionSamples& second);

}  // namespace veridyn
