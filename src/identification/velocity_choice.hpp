#pragma once

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "veridyn/identification/identification.hpp"
#include "veridyn/recordings/recording_quality.hpp"

namespace veridyn {

/// By how much ln(mean square) of a joint's torque must fall for its velocity to be taken from the
/// position: 2 % of the error.
constexpr double kVelocityGain = 0.04;

/// ln(mean square) per joint on the training recordings, on the rows that were fitted, (n).
VectorXd log_training_errors(const Identification& id);

/// By how much that falls per joint, on the rows as they were fitted and as recorded: of rows that
/// come late a derivative makes something that no repair will be there to mend.
VectorXd fall_of_errors(const Identification& before, const Identification& after);

/// Joints of which a recording has a finding of this name, of at least this severity.
std::set<int> joints_with_finding(const std::vector<RecordingQuality>& recordings,
                                  const std::string& finding, Severity least);

/// Which velocities are taken from the position, and the fit with them; no fit: none of them.
struct VelocityChoice {
  std::set<int> better;
  std::optional<Identification> fit;
};

/// Of the candidates those joints whose torque is predicted better by more than `least` with the
/// velocity from the position: all of them together first, then those alone that are better for it.
///
/// @param before  the fit without any of them.
/// @param look    the fit with the velocities of these joints from the position.
VelocityChoice choose_velocities(const Identification& before, std::set<int> candidates,
                                 double least,
                                 const std::function<Identification(const std::set<int>&)>& look);

/// Quality of the first rows of each recording, enough to show units and noise; empty where it cannot
/// be read: whoever reads it in earnest says why.
std::vector<RecordingQuality> glance_at(const Model& arm, const std::vector<std::string>& recordings,
                                        const PreprocessingOptions& how, int threads);

/// Joints whose recorded velocity the quality of these recordings doubts.
std::set<int> doubtful_velocities(const Model& arm, const std::vector<std::string>& recordings,
                                  const PreprocessingOptions& how, int threads);

}  // namespace veridyn
