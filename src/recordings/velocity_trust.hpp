#pragma once

#include <set>
#include <string>
#include <vector>

#include "veridyn/model/model.hpp"
#include "veridyn/recordings/recording_quality.hpp"

namespace veridyn {

/// Joints whose recorded velocities failed a quality check. One rule holds in all
/// commands: a `wrong` velocity is not used; a `doubtful` one is used unless a fit predicts the
/// torque better without it. identify() decides by its fit in both cases.
struct VelocityTrust {
  std::set<JointIndex> wrong;     ///< no derivative of the position: another unit, scale or sign, biased steps, late
  std::set<JointIndex> doubtful;  ///< noisier than the derivative of the position
};
VelocityTrust trust_in_velocities(const std::vector<RecordingQuality>& recordings);

/// One sentence per joint, such as "dq3 (insertion) is no derivative of q3, which is used instead".
std::vector<std::string> remarks_on(const std::set<JointIndex>& wrong, const Model& arm);

/// True if the finding means that its joint's velocity is wrong.
bool makes_velocity_wrong(const QualityFinding& finding);

}  // namespace veridyn
