#pragma once

#include <string>
#include <vector>

#include "diagnosis/shapes/candidate_data.hpp"
#include "veridyn/diagnosis/payload.hpp"

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

/// Mass, centre and moment of a load. A mass that may be zero has no centre, nor has any along an axis that no torque
/// sees.
std::vector<FoundParameter> load_parameters(const PayloadEstimate& load);

/// "a load of 0.3 kg (95 %: ...)"; of one whose mass may be zero its moment. @param of  load_parameters().
std::string load_phrase(const std::vector<FoundParameter>& of);

/// Parameters that two fits of one load both have, with the values of the first and intervals that hold those of either.
std::vector<FoundParameter> known_to_both(const std::vector<FoundParameter>& first,
                                          const std::vector<FoundParameter>& second);

/// Values and intervals of a finding whose effects are part of an identified arm.
/// @param names  of its parameters there.
void refresh(const Identification& id, const std::vector<std::string>& names, Finding& f);

/// Whether errors (n) fall in sum over the joints, of ln(mean square), and on a joint.
bool falls(const VectorXd& before, const VectorXd& after, std::optional<JointIndex> joint);

/// Verdict on a joint whose error on the held-out recordings is no number: they have no torque of it, or there are none.
JointVerdict not_judged(JointIndex joint, double held_out, const Identification& baseline);

/// Verdict on a joint whose torque no training recording has.
JointVerdict no_torque_verdict(JointIndex joint);

/// Confirmed where falls() of its errors on held-out parts of the training recordings.
FindingStatus status_of(const Finding& f);

}  // namespace veridyn
