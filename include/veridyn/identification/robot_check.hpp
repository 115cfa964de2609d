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
/// that they correct the recording only if the remaining error is near the torque's white noise. QualityKind lists
/// the mistakes.
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
