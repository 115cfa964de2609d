#pragma once

#include <optional>
#include <set>
#include <string>

#include "identification/fold_errors.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// A finding that may lose its name, and why.
struct LostRight {
  size_t finding = 0;  ///< as in `kept`
  int joint = 0;       ///< from 0: where it shows
  std::string why;
};

/// Reason for withdrawing a finding with these intervals: its only size may be zero, or one exceeds
/// all torques of its joint in training. Empty: it is kept.
std::string why_no_finding(const Finding& f, const Identification& fitted);

/// True if a joint, from 0, has a finding without a name over this signal ("q2"; empty: over any).
bool has_curve(const Diagnosis& d, int joint, const std::string& signal = {});

/// True for a wrong gain of a joint whose error without a name depends on the same torque: the recorded torque
/// is no constant multiple of the true one, as behind a limit or a dead zone.
bool is_no_factor(const Diagnosis& d, const Finding& f);

/// The first of the kept findings d.findings[first + k] for which why_no_finding() in the extended
/// model has an answer.
std::optional<LostRight> without_size(const Diagnosis& d, size_t first, const std::set<size_t>& kept);

/// Joints, from 0, that the extended model predicts worse than the baseline on held-out parts of the
/// training recordings, beyond the standard error of that difference between the parts.
std::vector<int> worse_joints(const FoldErrors& baseline, const FoldErrors& extended, const Thresholds& limits);

/// Of a joint that the extended model predicts worse than the baseline on held-out parts of the
/// training recordings, beyond the standard error of that difference between the parts, the finding
/// that helps it least; not one of `needed`.
std::optional<LostRight> worse_with(const Diagnosis& d, size_t first, const std::set<size_t>& kept,
                                    const std::set<size_t>& needed, const FoldErrors& baseline,
                                    const FoldErrors& extended, const Thresholds& limits);

/// Reason to ask once more without a name while the joints `above` have more than their floor; empty: there is none.
/// What acts through the motion of all joints (a wrong constant, zero or tilt) must show more on the other joints, or
/// it is the shadow of what has no name. A cable on a joint from one whose error without a name depends on that
/// joint's position: one cause acts on both.
std::string why_doubted(const Diagnosis& d, const Finding& f, const std::set<int>& above);

}  // namespace veridyn
