#pragma once

#include <set>
#include <vector>

#include "veridyn/recordings/recording_quality.hpp"

namespace veridyn {

/// Joints (from 0) whose recorded velocities the quality of these recordings doubts. The one rule of
/// all rooms: what is `wrong` is not used; what is `doubtful` is used unless a fit predicts the torque
/// better without. identify() lets its fit decide of both.
struct VelocityTrust {
  std::set<int> wrong;     ///< no derivative of the position: another scale, biased steps, late
  std::set<int> doubtful;  ///< noisier than the derivative of the position
};
VelocityTrust trust_in_velocities(const std::vector<RecordingQuality>& recordings);

/// The finding makes its joint's velocity a wrong one.
bool makes_velocity_wrong(const QualityFinding& finding);

}  // namespace veridyn
