#pragma once

#include <optional>

#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// A spectral line in a joint's residual that the motion does not have.
struct Vibration {
  double frequency = 0.0;  ///< [Hz]
  double amplitude = 0.0;  ///< [N m] or [N], mean over the held-out recordings
  double share = 0.0;      ///< share of the residual's mean square in the held-out recordings
};

/// Vibration at the frequency of the largest line in the residuals of the training recordings, between three
/// waves a recording and the filter's cut-off (in the spirit of Fisher's test for a hidden periodicity, Proc.
/// R. Soc. A 125, 1929), with its amplitude in the held-out recordings. Empty if it is less than
/// `unnamed_share` of the residual there, or if a position, velocity or torque of the motion has as large a
/// line in one of them.
std::optional<Vibration> vibration_of(const Identification& id, int joint, const Thresholds& limits);

}  // namespace veridyn
