#pragma once

#include <string>
#include <vector>

#include "veridyn/recordings/recording_quality.hpp"
#include "veridyn/recordings/preprocessing.hpp"

namespace veridyn {

/// Contradictions between a recording and the robot. The arm is identified briefly from the
/// recording as it is, and once for every hypothesis about mistaken signals; a hypothesis that
/// explains the torques much better is reported, with the option that corrects the signals.
/// Findings:
///
///   torque_sign    torques of a joint have the wrong sign; value: share of their square that the
///                  arm leaves unexplained with the sign reversed. Without a joint's coupling to
///                  others, or for all joints alike, its friction decides, which dissipates energy
///   swapped_joints two joints are exchanged, in their torques, in their motion, or in both
///   degrees        positions (and velocities) are degrees
///   current        efforts are motor currents: they fit through the robot file's drive gains, or
///                  differ from the torques of an arm with values by just these; a warning if they
///                  are small against the limits of the robot, as currents would be
///   torque_scale   torques differ from those of an arm with values by one factor per joint
///   not_compared   information: the recording leaves base parameters of the arm undetermined or
///                  nearly so, and wrong signals would fit as well; value: how many it
///                  determines. No fault is reported then
///
/// Only joints that move are checked. A recording that the arm explains, or one without motion, has
/// no finding.
/// @throws InvalidInput  as RecordingReader, or the recording belongs to another arm.
std::vector<QualityFinding> check_against(const Model& arm, const std::string& path,
                                          const PreprocessingOptions& options = {});

/// The same for a recording in memory, whose joints are the arm's in its order.
std::vector<QualityFinding> check_against(const Model& arm, Recording recording,
                                          const PreprocessingOptions& options = {});

}  // namespace veridyn
