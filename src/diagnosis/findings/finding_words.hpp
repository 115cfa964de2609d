#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// Updates values and intervals of a finding from an identification of the arm with its effects.
/// @param names  of its parameters in the identification.
void refresh(const Identification& id, const std::vector<std::string>& names, Finding& f);

/// True if errors (n) fall in the sum over joints of ln(mean square), and on the given joint.
bool error_falls(const VectorXd& before, const VectorXd& after, std::optional<JointIndex> joint);

/// Verdict on a joint whose error on the held-out recordings is no number: they have no torque of it, or there are none.
JointVerdict not_judged(JointIndex joint, double held_out, const Identification& baseline);

/// Verdict on a joint whose torque no training recording has.
JointVerdict no_torque_verdict(JointIndex joint);

/// Confirmed where error_falls() of its errors on held-out parts of the training recordings.
FindingStatus status_of(const Finding& f);

}  // namespace veridyn
