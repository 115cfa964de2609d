#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "causes/candidates.hpp"
#include "diagnosis/evidence/folds.hpp"
#include "diagnosis/stages/diagnosis_state.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/effects/channel_effect.hpp"

// Causes that are asked about only where a joint's error depends on positions and has no name, or the name of
// a force at each position: few of the recordings need them, and they would cost all others a part of their
// significance.

namespace veridyn {
namespace {

bool is_position(const std::string& signal) {
  return signal.size() > 1 && signal[0] == 'q' && std::isdigit(static_cast<unsigned char>(signal[1])) != 0;
}

// Joints with a finding without a name whose signals are positions.
std::set<int> joints_in_question(const Diagnosis& d) {
  std::set<int> out;
  for (const Finding& f : d.findings) {
    if (!f.shape || f.status != FindingStatus::kConfirmed) continue;
    const std::vector<std::string>& of = f.shape->signals;
    if (std::any_of(of.begin(), of.end(), is_position)) out.insert(f.joint->value);
  }
  return out;
}

// True if the finding is a force that depends on positions alone, or a lean of the base: on some motions what
// the arm's mounting or its tip does looks like one.
bool may_stand_for_the_arm(const Finding& f) {
  if (f.shape || f.status != FindingStatus::kConfirmed) return false;
  if (std::holds_alternative<ChannelError>(f.cause))
    return find_effect(effect_of(f.cause)).traits().role == EffectRole::kArm;
  if (!std::holds_alternative<NewEffect>(f.cause)) return false;
  const EffectTraits traits = find_effect(effect_of(f.cause)).traits();
  return traits.depends_on_position && traits.role == EffectRole::kForce && !traits.elementary;
}

int named_causes(const Diagnosis& d) {
  return static_cast<int>(std::count_if(d.findings.begin(), d.findings.end(), [](const Finding& f) {
    return !f.shape && f.status == FindingStatus::kConfirmed;
  }));
}

std::vector<std::string> later_causes(const Model& arm, const std::set<int>& joints) {
  std::vector<std::string> out;
  for (const AxisEffect* effect : axis_effects()) {
    if (!is_asked_later(*effect, arm) || !effect->traits().depends_on_position) continue;
    for (const int j : joints) out.push_back(to_text(arm, NewEffect{effect->name(), JointIndex{j}}));
  }
  for (const ChannelEffect* channel : channel_effects()) {
    const bool few = static_cast<int>(channel->parameters().size()) <= arm.joints();
    if (is_asked_later(*channel, arm) && few) out.push_back(channel->name());
  }
  return out;
}

// Errors of held-out parts of the training recordings with the curves that have no name.
VectorXd errors_with_curves(const DiagnosisState& x) {
  VectorXd out = x.fold_errors(x.d.extended).relative();
  for (const Finding& f : x.d.findings) {
    if (!f.shape || f.status != FindingStatus::kConfirmed) continue;
    const int j = f.joint->value;
    out[j] = std::min(out[j], f.folds_after[j]);
  }
  return out;
}

// True if a joint has another name or curve that is a function of its own position alone: then the name for
// that has another shape.
bool needs_another_force_of_position(const Diagnosis& d, JointIndex joint, const std::string& name) {
  const std::vector<std::string> own = {"q" + std::to_string(joint.value + 1)};
  return std::any_of(d.findings.begin(), d.findings.end(), [&](const Finding& f) {
    if (f.joint != joint || f.status != FindingStatus::kConfirmed) return false;
    if (f.shape) return f.shape->signals == own;
    if (!std::holds_alternative<NewEffect>(f.cause) || effect_of(f.cause) == name) return false;
    const EffectTraits traits = find_effect(effect_of(f.cause)).traits();
    return traits.depends_on_position && traits.uses_position && !traits.uses_velocity && !traits.elementary;
  });
}

// Makes the first finding of select_causes() part of the arm that other causes are tested beside.
void keep_first(DiagnosisState& y, size_t first) {
  y.start = y.d.extended;
  const Finding& f = y.d.findings[first];
  for (const EffectTerm& term : y.start.model->effects()) {
    if (!f.joint || term.effect != effect_of(f.cause) || term.axis.coefficients[f.joint->value] == 0.0) continue;
    const BoundEffect bound(*y.start.model, term);
    auto& names = y.fitted_by_start[first];
    for (size_t p = 0; p < find_effect(term.effect).parameters().size(); ++p)
      names.push_back(bound.parameter_name(static_cast<int>(p)));
  }
}

}  // namespace

void ask_later_causes(DiagnosisState& x) {
  if (!x.options.effects.empty() || x.d.changes || !x.d.extended.model || x.d.provisional ||
      !x.d.moving_as_one.empty())
    return;
  const std::set<int> joints = joints_in_question(x.d);
  if (joints.empty() && std::none_of(x.d.findings.begin(), x.d.findings.end(), may_stand_for_the_arm)) return;
  const std::vector<std::string> later = later_causes(x.arm, joints);
  if (later.empty()) return;
  DiagnosisState y = x;
  y.start = y.d.baseline;
  begin_tests(y);
  const size_t first = y.d.findings.size();
  y.options.effects = later;
  y.options.max_effects = 1;
  select_causes(y);
  if (y.d.findings.size() <= first || y.d.findings[first].status != FindingStatus::kConfirmed) return;
  y.d.findings.resize(first + 1);
  const std::optional<JointIndex> joint = y.d.findings[first].joint;
  const std::string name = effect_of(y.d.findings[first].cause);
  keep_first(y, first);
  y.options = x.options;
  y.d.not_supported.clear();
  y.d.cannot_tell.clear();
  correct_constants(y);
  select_causes(y);
  if (!y.d.extended.model) return;
  // The names say as much as the curves did, over all joints and on each that had one.
  const VectorXd curves = errors_with_curves(x);
  const VectorXd named = y.fold_errors(y.d.extended).relative();
  if (log_fall(curves, named) < 0.0) return;
  for (const int j : joints) {
    if (2.0 * std::log(named[j] / curves[j]) > x.options.thresholds.smallest_gain) return;
  }
  if (joints.empty() && named_causes(y.d) > named_causes(x.d)) return;
  y.d.hypotheses += static_cast<int>(later.size());
  account_for_errors(y);
  if (joint && needs_another_force_of_position(y.d, *joint, name)) return;
  x = std::move(y);
}

}  // namespace veridyn
