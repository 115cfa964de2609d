#pragma once

#include <string>
#include <vector>

#include "veridyn/identification/identification.hpp"
#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/recordings/recording_quality.hpp"

namespace veridyn {

/// Contradictions between a recording and the robot. One list of questions is asked: each is a transformation of the
/// recording or of the robot file that undoes one mistake. The arm is identified briefly as it is, and after each
/// transformation, alone and together; the score is what the arm leaves on rows that were held out, and what
/// contradicts physics (friction that gives energy) or the values of the file. A finding names the options that apply
/// all transformations found, and says that they mend it only where what is left is near the torque's white noise.
/// Findings (`value`: relative error of the torque after them):
///
///   torque_sign    torques of a joint, or of all, have the wrong sign
///   position_sign  a joint's position is counted the other way round
///   swapped_joints two joints are exchanged, in their torques, in their motion, or in both
///   encoder_zero   a joint's position is counted from another zero, near a quarter turn or half a turn away
///   degrees, turns, millimetres, counts, share_of_range, motor_side   positions or velocities in another unit
///   torque_unit, current   torques in another unit, as shares of the limits, in front of the gears, as currents
///   gravity        it points along another direction, or the torques hold none
///   dh_convention  the rows of the robot file are of the other convention
///   unexplained    nothing on the list explains most of the torque: the recording of another arm
///   weak_motion, hardly_moves   warnings: a joint moves over a small part of its range
///   not_compared   information: the recording leaves base parameters of the arm undetermined or
///                  nearly so, and wrong signals would fit as well; value: how many it
///                  determines. No fault is reported then
///
/// Only joints that move are asked about. A recording that the arm explains, or one without motion, has
/// no finding.
/// @throws InvalidInput  as RecordingReader, or the recording belongs to another arm.
std::vector<QualityFinding> check_against(const Model& arm, const std::string& path,
                                          const PreprocessingOptions& options = {});

/// The same for a recording in memory, whose joints are the arm's in its order.
std::vector<QualityFinding> check_against(const Model& arm, Recording recording,
                                          const PreprocessingOptions& options = {});

/// True if the finding is a question of check_against() that is answered by yes.
bool answers_question(const QualityFinding& finding);

/// Both lists, worst first, without findings of the quality that an answered question explains.
std::vector<QualityFinding> with_answers(std::vector<QualityFinding> answers, const std::vector<QualityFinding>& quality);

/// The faults of recordings that an identification explains badly; none where no error is large, which costs nothing.
/// @param fit  the identification from them.
std::vector<QualityFinding> questions_answered(const Model& arm, const std::vector<std::string>& train, const std::vector<std::string>& test,
                                               const PreprocessingOptions& options, const Identification& fit);

}  // namespace veridyn
