#pragma once

#include <optional>

#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// A spectral line of a joint's residual that the motion does not have.
struct Vibration {
  double frequency = 0.0;  ///< [Hz]
  double amplitude = 0.0;  ///< N m or N, mean of the held-out recordings
  double share = 0.0;      ///< of the residual's mean square there
};

/// The frequency is that of the largest line in the residuals of the training recordings, from three waves a
/// recording to the filter's cut-off, in the spirit of Fisher's test for a hidden periodicity (Proc. R. Soc. A
/// 125, 1929); how large it is, the held-out recordings say. Nothing if it is less than `unnamed_share` of the
/// residual there, or if a position, velocity or torque of the motion has as large a line in one of them.
std::optional<Vibration> vibration_of(const Identification& id, int joint, const Thresholds& limits);

}  // namespace veridyn
