#include "diagnosis/stages/later_causes.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "diagnosis/candidates/candidates.hpp"
#include "diagnosis/evidence/folds.hpp"
#include "effects/effect_names.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/effects/effect_facts.hpp"

// Causes that are asked about only where a joint's error depends on positions, or on another joint's torque, and has no
// name, or the name of a force at each position or of a cable: few of the recordings need them, and they would cost
// all others a part of their significance.

namespace veridyn {
namespace {

bool is_position(const std::string& signal) {
  return signal.size() > 1 && signal[0] == 'q' && std::isdigit(static_cast<unsigned char>(signal[1])) != 0;
}

// True for the torque or the acceleration of another joint.
bool is_torque_of_another(const std::string& signal, JointIndex joint) {
  const std::string own = std::to_string(joint.value + 1);
  const bool torque = signal.rfind("tau", 0) == 0 && signal != "tau" + own;
  return torque || (signal.rfind("ddq", 0) == 0 && signal != "ddq" + own);
}

// Joints with a finding without a name that depends on another joint's torque, or with a name that comes from
// another joint: a cable whose tension rises with a position looks like the torque that holds that joint up.
std::set<int> joints_that_others_act_on(const Diagnosis& d) {
  std::set<int> out;
  for (const Finding& f : d.findings) {
    if (f.status != FindingStatus::kConfirmed || !f.joint) continue;
    const bool cable = !f.shape && f.from && std::holds_alternative<NewEffect>(f.cause);
    const bool curve = f.shape && std::any_of(f.shape->signals.begin(), f.shape->signals.end(), [&](const std::string& s) {
                         return is_torque_of_another(s, *f.joint);
                       });
    if (cable || curve) out.insert(f.joint->value);
  }
  return out;
}

bool is_force_of_positions(const Cause& cause) {
  if (!std::holds_alternative<NewEffect>(cause) || !has_effect(effect_of(cause))) return false;
  const EffectTraits traits = find_effect(effect_of(cause)).traits();
  return traits.depends_on_position && traits.role == EffectRole::kForce && !traits.elementary;
}

// True if on some motions the arm's mounting, its tip or a wrong zero looks like this finding.
bool may_stand_for_another(const Finding& f) {
  return f.status == FindingStatus::kConfirmed && (std::holds_alternative<AddedLoad>(f.cause) ||
                                                   std::holds_alternative<KinematicError>(f.cause) || acts_through_positions(f));
}

struct Size {
  int causes = 0, parameters = 0;
};

Size size_of(const Diagnosis& d) {
  Size out;
  for (const Finding& f : d.findings) {
    if (f.shape || f.status != FindingStatus::kConfirmed) continue;
    ++out.causes;
    out.parameters += static_cast<int>(f.parameters.size());
  }
  return out;
}

// Wrong zeros of encoders: of first order they look like loads and leans, which have more parameters.
std::vector<std::string> wrong_zeros() {
  std::vector<std::string> out;
  for (const ChannelEffect* channel : channel_effects()) {
    if (!channel->whole_arm() && channel->traits().depends_on_position) out.push_back(channel->name());
  }
  return out;
}

// Errors of the channels of these joints that come from another joint.
std::vector<std::string> errors_from_others(const Model& arm, const std::set<int>& joints) {
  std::vector<std::string> out;
  for (const ChannelEffect* channel : channel_effects()) {
    if (channel->whole_arm() || !is_asked_later(*channel, arm) || !channel->traits().uses_source) continue;
    for (const int j : joints) out.push_back(to_text(arm, ChannelError{channel->name(), JointIndex{j}}));
  }
  return out;
}

std::vector<std::string> forces_of_positions(const Model& arm, const std::set<int>& joints) {
  std::vector<std::string> out;
  for (const AxisEffect* effect : axis_effects()) {
    if (!is_asked_later(*effect, arm) || !effect->traits().depends_on_position) continue;
    for (const int j : joints) out.push_back(to_text(arm, NewEffect{effect->name(), JointIndex{j}}));
  }
  return out;
}

std::vector<std::string> causes_through_positions(const Diagnosis& d, const Model& arm, const std::set<int>& joints) {
  std::vector<std::string> out = forces_of_positions(arm, joints);
  for (const ChannelEffect* channel : channel_effects()) {
    const bool few = static_cast<int>(channel->parameters().size()) <= arm.joints();
    if (is_asked_later(*channel, arm) && channel->whole_arm() && few) out.push_back(channel->name());
  }
  if (d.changes) {
    for (const std::string& zero : wrong_zeros()) out.push_back(zero);
  }
  return out;
}

// All that is asked about by default, and these causes.
std::vector<std::string> all_and(std::vector<std::string> out, const Model& arm) {
  for (const std::string& name : effect_names()) {
    if (!has_effect(name) || !is_asked_later(find_effect(name), arm)) out.push_back(name);
  }
  return out;
}

// Later causes that were accepted before: crosstalk on one joint does not give way to a stop on another.
std::vector<std::string> accepted_before(const DiagnosisState& x) {
  std::vector<std::string> out;
  for (const Finding& f : x.d.findings) {
    if (f.status == FindingStatus::kConfirmed && is_later(f, x.arm)) out.push_back(to_text(x.arm, f.cause));
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

// Joints with several names that act through positions: one law of another shape may be what they approximate.
std::set<int> joints_with_several(const Diagnosis& d) {
  std::set<int> once, out;
  for (const Finding& f : d.findings) {
    if (f.joint && acts_through_positions(f) && !once.insert(f.joint->value).second) out.insert(f.joint->value);
  }
  return out;
}

// True if names that act through positions take more of the joint's mean square, on held-out parts of the training
// recordings, than one cause alone took of what plain friction leaves.
bool take_more(const Diagnosis& d, int joint, const VectorXd& before, const VectorXd& after) {
  double taken = 0.0;
  for (const Finding& f : d.findings) {
    if (f.status == FindingStatus::kConfirmed && f.joint && f.joint->value == joint && acts_through_positions(f) &&
        f.folds_before.size() > joint && f.folds_after.size() > joint)
      taken += std::pow(f.folds_before[joint], 2) - std::pow(f.folds_after[joint], 2);
  }
  return taken > std::pow(before[joint], 2) - std::pow(after[joint], 2);
}

// Makes the first finding of select_causes() part of the arm that other causes are tested beside.
void keep_first(DiagnosisState& y, size_t first) {
  y.start = y.d.extended;
  const Finding& f = y.d.findings[first];
  for (const EffectTerm& term : y.start.model->effects()) {
    if (!f.joint || term.effect != effect_of(f.cause) || term.axis.coefficients[f.joint->value] == 0.0) continue;
    auto& names = y.fitted_by_start[first];
    for (std::string& name : EffectFacts(*y.start.model, term).parameter_names()) names.push_back(std::move(name));
  }
}

// True if the second diagnosis has no more names and predicts the held-out parts of the training recordings no
// worse; with more parameters clearly better, with fewer as well but for what is too little for a cause.
bool is_simpler(const DiagnosisState& x, const DiagnosisState& y, const VectorXd& errors, const VectorXd& others) {
  const Size before = size_of(x.d);
  const Size after = size_of(y.d);
  if (after.causes > before.causes) return false;
  const double lost = log_fall(others, errors);
  const Thresholds& limits = x.options.thresholds;
  if (after.parameters > before.parameters) return lost < -limits.smallest_gain;
  if (lost <= 0.0) return true;
  const double gained = log_fall(x.fold_errors(x.d.baseline).relative(), errors);
  return after.parameters < before.parameters && lost < limits.smallest_gain && lost < (1.0 - limits.tie) * gained;
}

// Names beside it that held-out parts do not confirm stood for the same.
void drop_unconfirmed(Diagnosis& d) {
  const auto gone = std::stable_partition(d.findings.begin(), d.findings.end(), [](const Finding& f) {
    return f.status == FindingStatus::kConfirmed || !is_force_of_positions(f.cause);
  });
  for (auto f = gone; f != d.findings.end(); ++f)
    d.not_supported.push_back({f->cause, f->p_value, "it is not confirmed beside a cause of the whole arm"});
  d.findings.erase(gone, d.findings.end());
}

// The cause that gave way, where it explains as much: these recordings cannot tell the two apart.
void add_rival(const Finding& gone, double gain, const Thresholds& limits, Finding& f) {
  if (std::abs(gain) < limits.smallest_gain && !(gone.joint == f.joint && effect_of(gone.cause) == effect_of(f.cause)))
    f.rivals.push_back({gone.cause, "explains as much with more parameters: these recordings cannot tell the two apart"});
}

// True if names predict as well as curves did, over all joints and on each that had one.
bool says_as_much(const VectorXd& curves, const VectorXd& named, const std::set<int>& with_curves, const Thresholds& limits) {
  return log_fall(curves, named) >= 0.0 && std::all_of(with_curves.begin(), with_curves.end(), [&](int j) {
    return 2.0 * std::log(named[j] / curves[j]) <= limits.smallest_gain;
  });
}

// Asks about these causes, and about all others beside the best of them: in place of what was found where that
// says as much, over all joints and on each that is in question.
// @param instead        a name that gives way where the other is simpler; nullptr: none.
// @param beside_curves  true: curves give way where the other says as much.
void ask(DiagnosisState& x, const std::vector<std::string>& later, const std::set<int>& in_question,
         const Finding* instead, bool beside_curves) {
  if (later.empty() || x.options.max_effects < 1) return;
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
  if (joint && in_question.count(joint->value) == 0 && instead != nullptr &&
      take_more(x.d, joint->value, y.fold_errors(y.start).relative(), y.fold_errors(y.d.extended).relative()))
    return;
  keep_first(y, first);
  y.options = x.options;
  y.d.not_supported.clear();
  y.d.cannot_tell.clear();
  correct_constants(y);
  std::vector<std::string> also = accepted_before(x);
  if (!joint) also.push_back(name);  // corrected already, it is corrected further beside the others
  if (!also.empty()) y.options.effects = all_and(std::move(also), x.arm);
  select_causes(y);
  y.options = x.options;
  if (!y.d.extended.model) return;
  if (!joint) drop_unconfirmed(y.d);
  // A cause on one joint gives way to that joint's curve: the others keep theirs beside it.
  std::set<int> replaced = in_question;
  if (joint) replaced = in_question.count(joint->value) != 0 ? std::set<int>{joint->value} : std::set<int>{};
  const VectorXd curves = errors_with_curves(x, joint);
  const VectorXd named = y.fold_errors(y.d.extended).relative();
  const bool simpler = instead != nullptr && is_simpler(x, y, curves, named);
  if (!simpler && (!beside_curves || !says_as_much(curves, named, replaced, x.options.thresholds))) return;
  y.d.hypotheses += static_cast<int>(later.size());
  if (simpler) add_rival(*instead, log_fall(curves, named), x.options.thresholds, y.d.findings[first]);
  account_for_errors(y);
  if (joint && needs_another_force_of_position(y.d, *joint, name)) return;
  x = std::move(y);
}

}  // namespace

bool is_later(const Finding& f, const Model& arm) {
  return !f.shape && has_effect(effect_of(f.cause)) && is_asked_later(find_effect(effect_of(f.cause)), arm);
}

bool acts_through_positions(const Finding& f) {
  if (f.shape) return false;
  if (std::holds_alternative<ChannelError>(f.cause)) return find_effect(effect_of(f.cause)).traits().role == EffectRole::kArm;
  return is_force_of_positions(f.cause);
}

std::set<int> joints_in_question(const Diagnosis& d) {
  std::set<int> out;
  for (const Finding& f : d.findings) {
    if (!f.shape || f.status != FindingStatus::kConfirmed) continue;
    const std::vector<std::string>& of = f.shape->signals;
    if (std::any_of(of.begin(), of.end(), is_position)) out.insert(f.joint->value);
  }
  return out;
}

VectorXd errors_with_curves(const DiagnosisState& x, std::optional<JointIndex> joint) {
  VectorXd out = x.fold_errors(x.d.extended).relative();
  for (const Finding& f : x.d.findings) {
    if (!f.shape || f.status != FindingStatus::kConfirmed || (joint && f.joint != joint)) continue;
    const int j = f.joint->value;
    out[j] = std::min(out[j], f.folds_after[j]);
  }
  return out;
}

void ask_about_crosstalk(DiagnosisState& x) {
  const std::set<int> joints = joints_that_others_act_on(x.d);
  ask(x, errors_from_others(x.arm, joints), joints, nullptr, true);
}

void ask_later_causes(DiagnosisState& x, const std::set<int>& hidden) {
  ask_about_crosstalk(x);
  const std::set<int> with_curves = joints_in_question(x.d);
  std::set<int> joints = with_curves;
  joints.insert(hidden.begin(), hidden.end());
  auto stands_in = std::find_if(x.d.findings.begin(), x.d.findings.end(), may_stand_for_another);
  // Of one wrong zero against a MODEL several names and curves can be made.
  if (x.d.changes && x.d.findings.size() > 1 && stands_in == x.d.findings.end()) stands_in = x.d.findings.begin();
  if (!joints.empty() || stands_in != x.d.findings.end()) {
    const bool against_names = stands_in != x.d.findings.end() && (joints.empty() || x.d.changes);
    ask(x, causes_through_positions(x.d, x.arm, joints), with_curves, against_names ? &*stands_in : nullptr, !joints.empty());
  }
  std::set<int> several = joints_with_several(x.d);
  for (const int j : joints) several.erase(j);
  const auto first = std::find_if(x.d.findings.begin(), x.d.findings.end(), [&](const Finding& f) {
    return f.joint && several.count(f.joint->value) != 0 && acts_through_positions(f);
  });
  if (first != x.d.findings.end()) ask(x, forces_of_positions(x.arm, several), {}, &*first, false);
}

}  // namespace veridyn
