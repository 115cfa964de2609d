#pragma once

namespace veridyn {

/// [s] between independent samples of IdentifiedBase::noise: its unit. Over a longer time the same effect has a
/// smaller deviation.
constexpr double kNoiseSeconds = 0.1;

}  // namespace veridyn
