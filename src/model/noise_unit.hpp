#pragma once

namespace veridyn {

/// Time [s] between independent samples to which IdentifiedBase::noise refers. Noise with the same effect and a
/// longer correlation time has a smaller deviation.
constexpr double kNoiseSeconds = 0.1;

}  // namespace veridyn
