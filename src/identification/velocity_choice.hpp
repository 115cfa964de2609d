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

/// ln(mean square) per joint on the training recordings, over the fitted rows, (n).
VectorXd log_training_errors(const Identification& id);

/// Decrease of these errors per joint, on the fitted rows and on the rows as recorded: the
/// derivative across late rows may be worse where they are not repaired.
VectorXd fall_of_errors(const Identification& before, const Identification& after);

/// Joints whose velocity is derived from the position, and the fit with them; nullopt: none.
struct VelocityChoice {
  std::set<int> better;
  std::optional<Identification> fit;
};

/// The candidates whose torque is predicted better by more than `least` with derived velocities:
/// tried all together first, then those that improve by themselves.
///
/// @param before  the fit without any of them.
/// @param look    computes the fit with derived velocities of these joints.
VelocityChoice choose_velocities(const Identification& before, std::set<int> candidates,
                                 double least,
                                 const std::function<Identification(const std::set<int>&)>& look);

/// The rows of a recording from which quick_quality() judges it.
RecordingOptions inspected_rows(const Model& arm, const PreprocessingOptions& how);

/// Quality of the first rows of each recording, sufficient for units and noise; empty if it cannot
/// be read, which a later step reports.
std::vector<RecordingQuality> quick_quality(const Model& arm, const std::vector<std::string>& recordings,
                                        const PreprocessingOptions& how, int threads);

/// Takes the velocities of these joints from the position, in training and in held-out recordings.
void derive_velocities(const std::set<int>& joints, IdentificationOptions& how);

/// Judges the velocities by the first rows of these recordings. Empty if the choice was made already:
/// a source of the velocities, joints, filtered signals, or how.choose_velocities is off.
VelocityTrust trust_in_velocities(const Model& arm, const std::vector<std::string>& recordings,
                                  const IdentificationOptions& how);

/// Repeats a fit with velocities derived from the position for those doubted joints at which that
/// predicts the torque better, and one that recordings with wrong velocities did not determine;
/// identify() on one machine and on many.
///
/// @param again  repeats it with other options. @returns  the better fit, with remarks.
Identification with_chosen_velocities(
    const Model& arm, Identification id, const std::vector<std::string>& train,
    IdentificationOptions how,
    const std::function<Identification(const IdentificationOptions&)>& again);

/// Replaces the velocities of a joint by those derived from its position, in `how`, if the velocities
/// of any of these recordings are wrong (trust_in_velocities).
/// @returns  the joints concerned.
std::set<int> exclude_wrong_velocities(const Model& arm, const std::vector<std::string>& train,
                                         const std::vector<std::string>& test,
                                         IdentificationOptions& how);

}  // namespace veridyn
