#pragma once

namespace veridyn {

/// Standard deviation of a quantiser's error as a share of its step, 1 / sqrt(12), for an error that is uniform
/// within one step. Source: Bennett, Bell System Technical Journal 27, 1948.
constexpr double kStepToDeviation = 0.28867513459481287;

}  // namespace veridyn
