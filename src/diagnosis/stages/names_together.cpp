#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/evidence/folds.hpp"
#include "diagnosis/findings/right_to_a_name.hpp"
#include "diagnosis/stages/diagnosis_state.hpp"
#include "diagnosis/stages/later_causes.hpp"
#include "veridyn/effects/effect.hpp"

// All names of a diagnosis as a set: against later causes, against the description without any name, and without
// those that are doubted.

namespace veridyn {
namespace {

bool is_name(const Finding& f) {
  if (f.shape) return false;
  if (std::holds_alternative<ChannelError>(f.cause) || std::holds_alternative<KinematicError>(f.cause)) return true;
  return std::holds_alternative<NewEffect>(f.cause) && !find_effect(effect_of(f.cause)).traits().elementary;
}

// Joints above their floor whose error names do not take for the most part.
std::set<int> joints_above_floor(const DiagnosisState& x) {
  std::set<int> out;
  for (const JointVerdict& v : x.d.joints) {
    const bool above = v.left > x.options.thresholds.at_floor * v.floor && v.state != JointState::kNamed;
    if (above || has_curve(x.d, v.joint.value)) out.insert(v.joint.value);
  }
  return out;
}

// True if forces of position are named on several joints, or an error of the whole arm: they may be the parts of
// a cause that acts on all.
bool may_be_parts_of_one(const Diagnosis& d) {
  std::set<int> joints;
  for (const Finding& f : d.findings) {
    if (!acts_through_positions(f)) continue;
    if (!f.joint) return true;
    joints.insert(f.joint->value);
  }
  return joints.size() > 1;
}

// Mean square of a joint's torque that a finding takes on held-out parts of the training recordings.
double taken(const Finding& f, int joint) {
  if (f.shape || f.folds_before.size() <= joint || f.folds_after.size() <= joint) return 0.0;
  return std::max(0.0, std::pow(f.folds_before[joint], 2) - std::pow(f.folds_after[joint], 2));
}

// True if a joint has an error without a name beside names; or if most of what is removable there is left, and
// most of what was taken is not friction: forces of position and errors of one channel imitate other causes.
bool names_are_doubtful(const DiagnosisState& x) {
  const std::vector<Finding>& all = x.d.findings;
  const std::set<int> above = joints_above_floor(x);
  return std::any_of(x.d.joints.begin(), x.d.joints.end(), [&](const JointVerdict& v) {
    if (has_curve(x.d, v.joint.value)) return std::any_of(all.begin(), all.end(), is_name);
    double of_forces = 0.0;
    double of_others = 0.0;
    for (const Finding& f : all) {
      const bool of_channel = f.joint && std::holds_alternative<ChannelError>(f.cause);
      (of_channel || acts_through_positions(f) ? of_forces : of_others) += taken(f, v.joint.value);
    }
    return above.count(v.joint.value) != 0 && of_forces > of_others;
  });
}

// The arm with plain friction, and curves for all that it leaves over: the description without names.
DiagnosisState without_names(const DiagnosisState& x) {
  DiagnosisState out = x;
  out.start = out.d.baseline;
  begin_tests(out);
  out.d.extended = out.start;
  account_for_errors(out);
  return out;
}

// Asks everything anew without the names that are doubted. True if there were any, and held-out parts are predicted
// as well without them. Beside a later cause, which would not be asked about, all are kept.
bool ask_without_doubted(DiagnosisState& x) {
  if (std::any_of(x.d.findings.begin(), x.d.findings.end(), [&](const Finding& f) { return is_later(f, x.arm); }))
    return false;
  const std::set<int> above = joints_above_floor(x);
  std::vector<NotSupported> lost;
  DiagnosisState y = x;
  for (const Finding& f : x.d.findings) {
    const std::string why = why_doubted(x.d, f, above);
    if (why.empty()) continue;
    lost.push_back({f.cause, f.p_value, why});
    y.not_asked.insert(to_text(x.arm, f.cause));
  }
  if (lost.empty()) return false;
  y.start = y.d.baseline;
  begin_tests(y);
  correct_constants(y);
  select_causes(y);
  if (!y.d.extended.model) return false;
  account_for_errors(y);
  if (log_fall(errors_with_curves(x), errors_with_curves(y)) < -x.options.thresholds.smallest_gain) return false;
  x = std::move(y);
  x.d.not_supported.insert(x.d.not_supported.begin(), lost.begin(), lost.end());
  return true;
}

}  // namespace

void test_names_together(DiagnosisState& x) {
  if (!x.options.effects.empty() || !x.d.extended.model || x.d.provisional || !x.d.moving_as_one.empty()) return;
  const bool compared = !x.d.changes && x.options.extended == ExtendedModel::kConfirmedOnly;
  std::optional<DiagnosisState> curves;
  std::set<int> hidden;
  if (compared && names_are_doubtful(x)) {
    curves = without_names(x);
    if (may_be_parts_of_one(x.d)) hidden = joints_in_question(curves->d);
  }
  ask_later_causes(x, hidden);
  if (!compared) return;
  if (curves && log_fall(errors_with_curves(x), errors_with_curves(*curves)) >= 0.0) {
    for (const Finding& f : x.d.findings) {
      if (is_name(f))
        curves->d.not_supported.insert(curves->d.not_supported.begin(),
                                       {f.cause, f.p_value, "smooth functions without any name predict held-out parts as well"});
    }
    curves->d.hypotheses = x.d.hypotheses;
    x = std::move(*curves);
    ask_about_crosstalk(x);
    return;
  }
  for (int turn = 0; turn < x.options.thresholds.withdrawals && ask_without_doubted(x); ++turn) {}
}

}  // namespace veridyn
