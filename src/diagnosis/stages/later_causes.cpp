#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "causes/candidates.hpp"
#include "diagnosis/evidence/folds.hpp"
#include "diagnosis/stages/diagnosis_state.hpp"
#include "veridyn/effects/channel_effect.hpp"

// Causes that are asked about only where a joint's error depends on positions and has no name: names for
// curves, which few of the recordings need, and which would cost all others a part of their significance.

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

// Names of forces that depend on positions and that held-out parts can do without, now that there is another
// one: the last of them first.
void drop_superfluous(DiagnosisState& y, size_t before) {
  VectorXd folds = y.fold_errors(y.d.extended).relative();
  for (size_t k = before; k-- > 0;) {
    const Finding f = y.d.findings[k];
    if (f.shape || !f.joint || !std::holds_alternative<NewEffect>(f.cause) ||
        !find_effect(effect_of(f.cause)).traits().depends_on_position)
      continue;
    ModelDescription description = y.d.extended.model->description();
    auto& effects = description.effects;
    const size_t terms = effects.size();
    effects.erase(std::remove_if(effects.begin(), effects.end(),
                                 [&](const EffectTerm& e) {
                                   const auto same = [&e](const EffectTerm& own) {
                                     return own.effect == e.effect && own.axis.coefficients == e.axis.coefficients;
                                   };
                                   const auto& file = y.arm.effects();
                                   return e.effect == effect_of(f.cause) &&
                                          e.axis.coefficients[f.joint->value] != 0.0 &&
                                          std::none_of(file.begin(), file.end(), same);
                                 }),
                  effects.end());
    if (effects.size() == terms) continue;
    description.identified.reset();
    Identification without = y.fit(Model(std::move(description)));
    if (!without.model) continue;
    const VectorXd left = y.fold_errors(without).relative();
    if (log_fall(folds, left) < -y.options.thresholds.smallest_gain) continue;
    folds = left;
    y.d.extended = std::move(without);
    y.d.not_supported.insert(y.d.not_supported.begin(), {f.cause, f.p_value, "a later finding explains it"});
    y.d.findings.erase(y.d.findings.begin() + static_cast<long>(k));
  }
}

}  // namespace

bool ask_later_causes(DiagnosisState& x) {
  if (!x.options.effects.empty() || x.d.changes || !x.d.extended.model || x.d.provisional ||
      !x.d.moving_as_one.empty())
    return false;
  const std::set<int> joints = joints_in_question(x.d);
  if (joints.empty()) return false;
  DiagnosisState y = x;
  y.options.effects = later_causes(x.arm, joints);
  if (y.options.effects.empty()) return false;
  y.start = x.d.extended;
  y.fitted_by_start.clear();
  VectorXd unnamed = x.fold_errors(x.d.extended).relative();
  auto& all = y.d.findings;
  for (const Finding& f : all) {
    if (f.shape && f.status == FindingStatus::kConfirmed)
      unnamed[f.joint->value] = std::min(unnamed[f.joint->value], f.folds_after[f.joint->value]);
  }
  all.erase(std::remove_if(all.begin(), all.end(), [](const Finding& f) { return f.shape.has_value(); }), all.end());
  const size_t before = all.size();
  const std::vector<NotSupported> not_supported = y.d.not_supported;
  const std::vector<CannotTell> cannot_tell = y.d.cannot_tell;
  y.options.max_effects = static_cast<int>(before - y.contacts) + 1;  // one, and then the account anew
  select_causes(y);
  y.d.not_supported = not_supported;
  y.d.cannot_tell = cannot_tell;
  const bool found = std::any_of(all.begin() + static_cast<long>(before), all.end(), [](const Finding& f) {
    return f.status == FindingStatus::kConfirmed;
  });
  if (!found || !y.d.extended.model) return false;
  // The name says as much as the curves did, over all joints and on each that had one.
  const VectorXd named = y.fold_errors(y.d.extended).relative();
  if (log_fall(unnamed, named) < 0.0) return false;
  for (const int j : joints) {
    if (2.0 * std::log(named[j] / unnamed[j]) > x.options.thresholds.smallest_gain) return false;
  }
  all.erase(std::remove_if(all.begin() + static_cast<long>(before), all.end(),
                           [](const Finding& f) { return f.status != FindingStatus::kConfirmed; }),
            all.end());
  drop_superfluous(y, before);
  y.d.hypotheses += x.d.hypotheses;
  x.d = std::move(y.d);
  return true;
}

}  // namespace veridyn
