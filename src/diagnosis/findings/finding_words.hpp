#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// Updates values and intervals of a finding from an identification of the extended arm.
/// @param names  of the finding's parameters in the identification.
void refresh(const Identification& id, const std::vector<std::string>& names, Finding& f);

/// True if the errors (n) decrease in the sum over joints of ln(mean square), and on the given joint.
bool error_falls(const VectorXd& before, const VectorXd& after, std::optional<JointIndex> joint);

/// Verdict on a joint without a held-out error: the held-out recordings do not have its torque, or there are
/// none.
JointVerdict not_judged(JointIndex joint, double held_out, const Identification& baseline);

/// Verdict on a joint whose torque is in no training recording.
JointVerdict no_torque_verdict(JointIndex joint);

/// Confirmed if error_falls() for its errors on held-out parts of the training recordings.
FindingStatus status_of(const Finding& f);

}  // namespace veridyn
