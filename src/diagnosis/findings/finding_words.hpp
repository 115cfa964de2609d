#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// Values and intervals of a finding whose effects are part of an identified arm.
/// @param names  of its parameters there.
void refresh(const Identification& id, const std::vector<std::string>& names, Finding& f);

/// Whether errors (n) fall in sum over the joints, of ln(mean square), and on a joint.
bool error_falls(const VectorXd& before, const VectorXd& after, std::optional<JointIndex> joint);

/// Verdict on a joint whose error on the held-out recordings is no number: they have no torque of it, or there are none.
JointVerdict not_judged(JointIndex joint, double held_out, const Identification& baseline);

/// Verdict on a joint whose torque no training recording has.
JointVerdict no_torque_verdict(JointIndex joint);

/// Confirmed where falls() of its errors on held-out parts of the training recordings.
FindingStatus status_of(const Finding& f);

}  // namespace veridyn
