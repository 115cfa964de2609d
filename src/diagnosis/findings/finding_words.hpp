#pragma once

#include <string>
#include <vector>

#include "diagnosis/shapes/candidate_data.hpp"

namespace veridyn {

/// A finding of a hypothesis with its place and nothing else.
Finding finding_at(const Hypothesis& h);

/// "That is unusually large ..." where a parameter is beyond what such errors usually are; empty
/// elsewhere. It decides nothing.
std::string remark_on_size(const Hypothesis& h, const std::vector<double>& values);

/// A finding of a channel's error or a tilt that is undone already.
Finding channel_finding(const CandidateData& asked, const Hypothesis& h,
                        const std::vector<double>& values, const VectorXd& half_widths);

/// Rivals of an accepted hypothesis, with what they gain.
std::vector<Rival> rivals_of(const CandidateData& asked, const NormalBlocks& data, const Hypothesis& h,
                             const Accepted& accepted, bool changes);

/// Values and intervals of a finding whose effects are part of an identified arm.
/// @param names  of its parameters there.
void refresh(const Identification& id, const std::vector<std::string>& names, Finding& f);

/// Whether errors (n) fall in sum over the joints, of ln(mean square), and on a joint.
bool falls(const VectorXd& before, const VectorXd& after, std::optional<JointIndex> joint);

/// Verdict on a joint whose error on the held-out recordings is no number: they have no torque of it, or there are none.
JointVerdict not_judged(JointIndex joint, double held_out, const Identification& baseline);

/// Confirmed where falls() of its errors on held-out parts of the training recordings.
FindingStatus status_of(const Finding& f);

}  // namespace veridyn
