#pragma once

#include <vector>

#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Orders of ripple worth asking about, per joint: the highest peaks of the spectrum of what the
/// model leaves unexplained, taken over the joint's position. Waves per turn of a revolute joint,
/// [rad/m] of a prismatic one; at most `most` each, none where nothing stands out.
std::vector<std::vector<double>> ripple_orders(const Identification& id, const Thresholds& limits = {},
                                               int most = 2);

}  // namespace veridyn
