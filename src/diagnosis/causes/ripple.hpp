#pragma once

#include <vector>

#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Candidate orders of ripple, per joint: the highest peaks of the residual's spectrum over the
/// joint's position. Waves per turn of a revolute joint, [rad/m] of a prismatic one; at most two each,
/// none without a significant peak.
std::vector<std::vector<double>> ripple_orders(const Identification& id, const Thresholds& limits);

}  // namespace veridyn
