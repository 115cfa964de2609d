#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "causes/candidates.hpp"
#include "diagnosis/evidence/folds.hpp"
#include "diagnosis/findings/right_to_a_name.hpp"
#include "diagnosis/stages/diagnosis_state.hpp"
#include "model/effect_names.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/effects/effect.hpp"

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

bool is_force_of_positions(const Cause& cause) {
  if (!std::holds_alternative<NewEffect>(cause) || !has_effect(effect_of(cause))) return false;
  const EffectTraits traits = find_effect(effect_of(cause)).traits();
  return traits.depends_on_position && traits.role == EffectRole::kForce && !traits.elementary;
}

// True if the finding is a force that depends on positions alone, a lean of the base or a load: on some motions
// what the arm's mounting, its tip or a wrong zero does looks like one.
bool may_stand_for_another(const Finding& f) {
  if (f.shape || f.status != FindingStatus::kConfirmed) return false;
  const auto* channel = std::get_if<ChannelError>(&f.cause);
  return std::holds_alternative<AddedLoad>(f.cause) || is_force_of_positions(f.cause) ||
         (channel != nullptr && find_effect(effect_of(f.cause)).traits().role == EffectRole::kArm);
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

std::vector<std::string> later_causes(const Diagnosis& d, const Model& arm, const std::set<int>& joints) {
  std::vector<std::string> out;
  for (const AxisEffect* effect : axis_effects()) {
    if (!is_asked_later(*effect, arm) || !effect->traits().depends_on_position) continue;
    for (const int j : joints) out.push_back(to_text(arm, NewEffect{effect->name(), JointIndex{j}}));
  }
  for (const ChannelEffect* channel : channel_effects()) {
    const bool few = static_cast<int>(channel->parameters().size()) <= arm.joints();
    if (is_asked_later(*channel, arm) && few) out.push_back(channel->name());
  }
  if (d.changes) {
    for (const std::string& zero : wrong_zeros()) out.push_back(zero);
  }
  return out;
}

// All that is asked about by default, and one cause more: an error of the whole arm that is corrected already
// is corrected further beside the others.
std::vector<std::string> all_and(const std::string& one, const Model& arm) {
  std::vector<std::string> out;
  for (const std::string& name : effect_names()) {
    if (!has_effect(name) || !is_asked_later(find_effect(name), arm)) out.push_back(name);
  }
  out.push_back(one);
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
    if (v.state == JointState::kUnnamed || above) out.insert(v.joint.value);
  }
  return out;
}

// True for a force of position on a joint, and for a tilt of the whole arm.
bool is_force_of_position(const Finding& f) {
  if (!is_name(f) || !has_effect(effect_of(f.cause))) return false;
  const EffectTraits traits = find_effect(effect_of(f.cause)).traits();
  if (!std::holds_alternative<NewEffect>(f.cause)) return !f.joint && traits.depends_on_position;
  return traits.depends_on_position && (traits.uses_source || !traits.uses_velocity);
}

// True if forces of position are named on several joints, or one on the whole arm: they may be the parts of
// a cause that acts on all.
bool may_be_parts_of_one(const Diagnosis& d) {
  std::set<int> joints;
  for (const Finding& f : d.findings) {
    if (is_force_of_position(f)) joints.insert(f.joint ? f.joint->value : -1);
  }
  return joints.size() > 1 || joints.count(-1) != 0;
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
    if (v.state == JointState::kUnnamed) return std::any_of(all.begin(), all.end(), is_name);
    double of_forces = 0.0;
    double of_others = 0.0;
    for (const Finding& f : all) {
      const bool of_channel = f.joint && std::holds_alternative<ChannelError>(f.cause);
      (of_channel || is_force_of_position(f) ? of_forces : of_others) += taken(f, v.joint.value);
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

// Puts a later cause, and what is found beside it, in place of what was found, where that says as much.
// @param hidden  joints with curves over positions where all names are taken away
void ask_later_causes(DiagnosisState& x, const std::set<int>& hidden) {
  const std::set<int> with_curves = x.d.changes ? std::set<int>() : joints_in_question(x.d);
  std::set<int> joints = with_curves;
  joints.insert(hidden.begin(), hidden.end());
  auto stands_in = std::find_if(x.d.findings.begin(), x.d.findings.end(), may_stand_for_another);
  // Of one wrong zero against a MODEL several names and curves can be made.
  if (x.d.changes && x.d.findings.size() > 1 && stands_in == x.d.findings.end()) stands_in = x.d.findings.begin();
  if (joints.empty() && stands_in == x.d.findings.end()) return;
  const std::vector<std::string> later = later_causes(x.d, x.arm, joints);
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
  if (!joint) y.options.effects = all_and(name, x.arm);
  select_causes(y);
  y.options = x.options;
  if (!y.d.extended.model) return;
  if (!joint) drop_unconfirmed(y.d);
  // The names say as much as the curves did, over all joints and on each that had one.
  const VectorXd curves = errors_with_curves(x);
  const VectorXd named = y.fold_errors(y.d.extended).relative();
  if (joints.empty() ? !is_simpler(x, y, curves, named) : log_fall(curves, named) < 0.0) return;
  for (const int j : with_curves) {
    if (2.0 * std::log(named[j] / curves[j]) > x.options.thresholds.smallest_gain) return;
  }
  y.d.hypotheses += static_cast<int>(later.size());
  if (joints.empty()) add_rival(*stands_in, log_fall(curves, named), x.options.thresholds, y.d.findings[first]);
  account_for_errors(y);
  if (joint && needs_another_force_of_position(y.d, *joint, name)) return;
  x = std::move(y);
}

bool is_later(const Finding& f, const Model& arm) {
  return !f.shape && has_effect(effect_of(f.cause)) && is_asked_later(find_effect(effect_of(f.cause)), arm);
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
    return;
  }
  for (int turn = 0; turn < x.options.thresholds.withdrawals && ask_without_doubted(x); ++turn) {}
}

}  // namespace veridyn
