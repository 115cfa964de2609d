#pragma once

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "veridyn/identification/identification.hpp"
#include "recordings/velocity_trust.hpp"
#include "veridyn/recordings/recording_quality.hpp"

namespace veridyn {

/// ln(mean square) of each joint's error (n), over the fitted rows of the training recordings.
VectorXd log_training_errors(const Identification& id);

/// Decrease of log_training_errors() (n), on the fitted rows or on the rows as recorded, whichever is smaller:
/// across late rows that are not repaired, the derivative of the position may be worse.
VectorXd decrease_of_errors(const Identification& before, const Identification& after);

/// Joints whose velocity is derived from the position, and the fit with them; nullopt: none.
struct VelocityChoice {
  std::set<JointIndex> better;
  std::optional<Identification> fit;
};

/// Chooses the candidates whose torque is predicted better by more than `least` with derived velocities:
/// all of them together or, if some do not improve, once more the others.
///
/// @param before  the fit without derived velocities.
/// @param refit   computes the fit with derived velocities of these joints.
VelocityChoice choose_velocities(const Identification& before, std::set<JointIndex> candidates,
                                 double least,
                                 const std::function<Identification(const std::set<JointIndex>&)>& refit);

/// The rows of a recording on which quick_quality() is based.
RecordingOptions inspected_rows(const Model& arm, const PreprocessingOptions& how);

/// Quality of the first rows of each recording, sufficient for units and noise; empty if the file cannot be
/// read, which a later step reports.
std::vector<RecordingQuality> quick_quality(const Model& arm, const std::vector<std::string>& recordings,
                                        const PreprocessingOptions& how, int threads);

/// Sets in the options that these joints' velocities are derived from the position, in training and held-out recordings.
void derive_velocities(const std::set<JointIndex>& joints, IdentificationOptions& how);

/// Assesses the velocities by the first rows of these recordings. Empty if the choice has been made: by a
/// source of velocities, chosen joints or filtered signals in the options, or how.choose_velocities = false.
VelocityTrust trust_in_velocities(const Model& arm, const std::vector<std::string>& recordings,
                                  const IdentificationOptions& how);

/// Repeats a fit with derived velocities for those doubtful joints whose torque they predict better, and a
/// fit that failed because of wrong velocities; used by identify() on one machine and on many.
///
/// @param again  repeats it with other options. @returns  the better fit, with remarks.
Identification with_chosen_velocities(
    const Model& arm, Identification id, const std::vector<std::string>& train,
    IdentificationOptions how,
    const std::function<Identification(const IdentificationOptions&)>& again);

/// Switches the joints whose velocities are wrong in any of these recordings (trust_in_velocities) to derived
/// velocities, in `how`.
/// @returns  these joints.
std::set<JointIndex> exclude_wrong_velocities(const Model& arm, const std::vector<std::string>& train,
                                         const std::vector<std::string>& test,
                                         IdentificationOptions& how);

}  // namespace veridyn
