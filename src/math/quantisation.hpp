#pragma once

namespace veridyn {

/// Standard deviation of a quantiser's error, which is uniform within one step, over that step: 1 / sqrt(12).
/// Source: Bennett, Bell System Technical Journal 27, 1948.
constexpr double kStepToDeviation = 0.28867513459481287;

}  // namespace veridyn
