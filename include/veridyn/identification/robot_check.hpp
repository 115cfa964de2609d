#pragma once

#include <string>
#include <vector>

#include "veridyn/identification/identification.hpp"
#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/recordings/recording_quality.hpp"

namespace veridyn {

/// Finds contradictions between a recording and the robot by testing a list of hypotheses. Each is a
/// transformation of the recording or of the robot file that corrects one mistake. A short identification is
/// repeated for the unchanged data and after each transformation, alone and combined; the score is the error
/// on held-out rows, with penalties for results that contradict physics (friction that supplies energy) or
/// the values of the file. A finding lists the options that apply all accepted transformations; it states
/// that they correct the recording only if the remaining error is near the torque's white noise. Findings
/// (`value`: relative error of the torque after the transformations):
///
///   torque_sign    torques of a joint, or of all, have the wrong sign
///   position_sign  a joint's position is counted with the opposite sign
///   swapped_joints two joints are exchanged, in their torques, in their motion, or in both
///   encoder_zero   a joint's position is counted from another zero, near a quarter turn or half a turn away
///   degrees, turns, millimetres, counts, share_of_range, motor_side   positions or velocities in another unit
///   given_unit     the recording fits without a unit that was given
///   torque_unit, current   torques in another unit, as shares of the limits, in front of gears, as currents of drives
///   brakes         torques of an arm at rest are not those that hold it
///   no_sign        a torque of one sign that does not follow from the motion
///   gravity        it has another direction, or the torques contain none
///   dh_convention  the rows of the robot file follow the other convention
///   unexplained    nothing on the list explains most of the torque: the recording of another arm; a warning: nothing
///                  explains a part of a joint's torque
///   beyond_effort  torques several times the largest effort; beyond_limits, beyond_speed: warnings
///   values         a warning: free parameters explain the torque far better than known values of the robot
///   weak_motion, hardly_moves   warnings: a joint moves over a small part of its range
///   not_compared   information: the recording leaves base parameters of the arm undetermined or
///                  nearly so, and wrong signals would fit as well; value: number of determined
///                  ones. No other fault is reported then
///
/// Only joints that move are tested. A recording that the arm explains, or one without motion, has
/// no finding.
/// @throws InvalidInput  as RecordingReader, or the recording belongs to another arm.
std::vector<QualityFinding> check_against(const Model& arm, const std::string& path,
                                          const PreprocessingOptions& options = {});

/// check_against() for a recording in memory, whose joints are the arm's in its order.
std::vector<QualityFinding> check_against(const Model& arm, Recording recording,
                                          const PreprocessingOptions& options = {});

/// True for a contradiction that check_against() found, except warnings and information.
bool is_contradiction(const QualityFinding& finding);

/// The findings of both lists, worst first, without those of `quality` that a contradiction explains.
std::vector<QualityFinding> merged_findings(std::vector<QualityFinding> contradictions, const std::vector<QualityFinding>& quality);

/// Contradictions in recordings that an identification explains badly; empty, without computation, if no error is large.
/// @param fit  the identification from them.
std::vector<QualityFinding> contradictions_in(const Model& arm, const std::vector<std::string>& train, const std::vector<std::string>& test,
                                               const PreprocessingOptions& options, const Identification& fit);

}  // namespace veridyn
