#pragma once

#include <string>
#include <vector>

#include "veridyn/recordings/recording_quality.hpp"
#include "veridyn/recordings/preprocessing.hpp"

namespace veridyn {

/// What of a recording contradicts the robot: the arm is identified in short from the recording as it
/// is, and once for every way in which its signals may have been mistaken; a way that explains the
/// torques much better is named, with the option that mends it. Findings:
///
///   torque_sign    torques of a joint against their motion; value: share of their square that the
///                  arm leaves unexplained when they are turned round. Without a joint's coupling to
///                  others, or for all joints alike, its friction decides: it takes energy
///   swapped_joints two joints changed places, in their torques, in their motion, or in both
///   degrees        positions (and velocities) are degrees
///   current        efforts are motor currents: they fit through the robot file's drive gains, or
///                  differ from the torques of an arm with values by just these; a warning where they
///                  are merely as small as currents beside the robot's limits
///   torque_scale   torques differ from those of an arm with values by one factor a joint
///   not_compared   information: the recording leaves base parameters of the arm open or hardly tells
///                  them apart, so that wrong signals would fit as well; value: how many it
///                  determines. No fault is named then
///
/// Only joints that move are judged. Nothing is found in a recording that the arm explains, or in
/// one without motion.
/// @throws InvalidInput  as RecordingReader does, or the recording is not of this arm.
std::vector<QualityFinding> check_against(const Model& arm, const std::string& path,
                                          const PreprocessingOptions& options = {});

/// The same for a recording in memory, whose joints are the arm's in its order.
std::vector<QualityFinding> check_against(const Model& arm, Recording recording,
                                          const PreprocessingOptions& options = {});

}  // namespace veridyn
