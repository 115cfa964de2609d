#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "diagnosis/evidence/held_out.hpp"
#include "diagnosis/findings/right_to_a_name.hpp"
#include "diagnosis/stages/account.hpp"
#include "veridyn/effects/cause.hpp"

// Names that what is left over speaks against.

namespace veridyn {
namespace {

using Reasons = std::map<size_t, const char*>;  // by index of a finding

// True if the effect's torque is a function of this signal.
bool acts_through(const Finding& f, const MotionSignal& signal) {
  const EffectTraits traits = find_effect(effect_of(f.cause)).traits();
  if (signal.kind == SignalKind::kTime) return traits.depends_on_time;
  const bool motion = signal.kind == SignalKind::kPosition || signal.kind == SignalKind::kVelocity;
  if (signal.joint != f.joint->value) return traits.uses_source && motion;
  switch (signal.kind) {
    case SignalKind::kPosition: return traits.uses_position || traits.memory;
    case SignalKind::kVelocity: return traits.uses_velocity || traits.memory;
    case SignalKind::kAcceleration: return traits.uses_acceleration;
    case SignalKind::kTorque: return traits.uses_load;
    case SignalKind::kHistory: return traits.memory;
    case SignalKind::kTime: break;
  }
  return false;
}

// The step of a finding begins where that of the names withdrawn before it began.
void begin_at(Finding& f, const std::vector<VectorXd>& before, const Diagnosis& d) {
  f.test_before = before[0];
  if (f.folds_before.size() == before[1].size()) f.folds_before = before[1];
  f.explains = explained_share(f.test_before, f.test_after, d.baseline);
}

void withdraw(DiagnosisState& x, const Reasons& lost) {
  Diagnosis& d = x.d;
  std::vector<Finding> kept;
  std::map<size_t, std::vector<std::string>> fitted_by_start;  // by the new indices
  std::vector<VectorXd> begins;  // errors before the names that go, held out and of folds
  for (size_t k = 0; k < d.findings.size(); ++k) {
    Finding& f = d.findings[k];
    const auto why = lost.find(k);
    const bool is_step = !f.shape && f.test_before.size() > 0;
    if (why == lost.end()) {
      if (is_step && !begins.empty()) begin_at(f, std::exchange(begins, {}), d);
      const auto names = x.fitted_by_start.find(k);
      if (names != x.fitted_by_start.end()) fitted_by_start.emplace(kept.size(), std::move(names->second));
      kept.push_back(std::move(f));
      continue;
    }
    if (is_step && begins.empty()) begins = {f.test_before, f.folds_before};
    d.not_supported.insert(d.not_supported.begin(), {f.cause, f.p_value, why->second});
    d.remarks.push_back(fmt::format("Withdrawn: {} Not named, for {}.", d.sentence(f), why->second));
  }
  d.findings = std::move(kept);
  x.fitted_by_start = std::move(fitted_by_start);
}

// Reasons against the names of an extended model.
class Withdrawal {
 public:
  Withdrawal(const DiagnosisState& x, const UnexplainedError& left)
      : x_(x), d_(x.d), limits_(x.options.thresholds), left_(left) {}

  // Names that go, and the arm fitted without them; nothing: all stay.
  std::optional<std::pair<Reasons, Identification>> run() const {
    Reasons lost;
    for (size_t k = 0; k < d_.findings.size(); ++k) {
      if (is_small(d_.findings[k]))
        lost[k] = "it is small beside what has no name on its joint, which may be what it stands for";
      else if (is_part_of_torque_curve(d_.findings[k]))
        lost[k] = "the recorded torque of its joint is in no constant proportion to the true one, which it may stand for";
    }
    std::optional<Identification> without;
    if (!lost.empty()) without = refitted_without(lost);
    const bool told_apart = !d_.provisional && d_.moving_as_one.empty();
    for (size_t k = 0; told_apart && !without && k < d_.findings.size(); ++k) {
      if (!may_stand_for_another(d_.findings[k])) continue;
      lost = alike(d_.findings[k], "without it smooth functions of other signals predict its joint as well");
      without = refitted_without(lost);
      if (without && !is_encompassed(d_.findings[k], *without)) without.reset();
    }
    if (!without) return std::nullopt;
    return std::make_pair(std::move(lost), std::move(*without));
  }

 private:
  bool has_unnamed(int joint) const { return has_curve(d_, joint); }

  // The findings of one effect on one joint (cables from several joints), which stand and fall together.
  Reasons alike(const Finding& f, const char* why) const {
    Reasons out;
    for (size_t k = 0; k < d_.findings.size(); ++k) {
      const Finding& other = d_.findings[k];
      if (!other.shape && other.joint == f.joint && effect_of(other.cause) == effect_of(f.cause)) out[k] = why;
    }
    return out;
  }

  bool is_withdrawable(const Finding& f) const {
    return !f.shape && f.joint && f.status == FindingStatus::kConfirmed &&
           std::holds_alternative<NewEffect>(f.cause) && f.folds_before.size() > 0;
  }

  bool is_small(const Finding& f) const {
    if (!is_withdrawable(f) || !has_unnamed(f.joint->value)) return false;
    const int j = f.joint->value;
    const double unnamed = left_.unnamed[j] * left_.folds[j] * left_.folds[j];
    const double own = f.folds_before[j] * f.folds_before[j] - f.folds_after[j] * f.folds_after[j];
    return own < limits_.small_beside_unnamed * unnamed;
  }

  // True for what is in proportion to a torque that is recorded in no constant proportion.
  bool is_part_of_torque_curve(const Finding& f) const {
    if (!is_withdrawable(f) || !find_effect(effect_of(f.cause)).traits().uses_load) return false;
    return std::any_of(d_.findings.begin(), d_.findings.end(), [&](const Finding& gain) {
      return gain.joint == f.joint && is_no_factor(d_, gain);
    });
  }

  bool may_stand_for_another(const Finding& f) const {
    if (!is_withdrawable(f) || find_effect(effect_of(f.cause)).traits().elementary) return false;
    const JointVerdict& v = d_.joints[f.joint->value];
    return has_unnamed(v.joint.value) || v.left > limits_.at_floor * v.floor;
  }

  // The extended arm without the effects of these findings.
  std::optional<Identification> refitted_without(const Reasons& lost) const {
    ModelDescription description = d_.extended.model->description();
    const auto is_in = [](const std::vector<EffectTerm>& all, const EffectTerm& one) {
      return std::any_of(all.begin(), all.end(), [&one](const EffectTerm& e) {
        return e.effect == one.effect && e.axis.coefficients == one.axis.coefficients;
      });
    };
    auto& effects = description.effects;
    const size_t before = effects.size();
    for (const auto& [k, why] : lost) {
      const Finding& f = d_.findings[k];
      effects.erase(std::remove_if(effects.begin(), effects.end(),
                                   [&f = f, &is_in, this](const EffectTerm& e) {
                                     return e.effect == effect_of(f.cause) &&
                                            e.axis.coefficients[f.joint->value] != 0.0 &&
                                            !is_in(x_.arm.effects(), e);
                                   }),
                    effects.end());
    }
    if (effects.size() == before) return std::nullopt;
    description.identified.reset();
    Identification out = x_.fit(Model(std::move(description)));
    if (!out.model) return std::nullopt;
    return out;
  }

  // True if what a cable leaves over still depends on the signals that it acts through, and on no other. A name of
  // the joint itself says what its curve depends on, whatever the curve.
  bool has_another_shape(const Finding& f) const {
    const EffectTraits traits = find_effect(effect_of(f.cause)).traits();
    if (!traits.uses_source) return false;
    return std::any_of(d_.findings.begin(), d_.findings.end(), [&](const Finding& curve) {
      if (!curve.shape || curve.status != FindingStatus::kConfirmed || curve.joint != f.joint) return false;
      const std::vector<std::string>& of = curve.shape->signals;
      return std::all_of(left_.signals.begin(), left_.signals.end(), [&](const MotionSignal& s) {
        return std::find(of.begin(), of.end(), s.name) == of.end() || acts_through(f, s);
      });
    });
  }

  // True if smooth terms beside the model without a finding, the first of them of a signal that it does not
  // act through, leave no more of a joint's held-out parts than those beside the extended model; where the
  // extended model needs none, clearly less: smooth functions imitate any cause.
  bool is_encompassed(const Finding& f, const Identification& without) const {
    const int j = f.joint->value;
    const auto rows = [&](const std::vector<RecordingError>& of) {
      return motion_rows(without, of, d_.excluded_intervals, left_.signals);
    };
    const std::vector<SmoothTerm> terms = smooth_terms(left_.signals, j, limits_);
    const Dependence found = find_dependence(j, rows(without.train), rows(without.test), terms, limits_);
    if (!is_clear(found, x_)) return false;
    const std::vector<int>& main = terms[found.model.chosen.front().term].signals;
    const bool own = std::all_of(main.begin(), main.end(), [&](int s) {
      return acts_through(f, left_.signals[s]);
    });
    if (own && !has_another_shape(f)) return false;
    const double left = without_share(x_.fold_errors(without).relative()[j], found.predicted_of_folds.back());
    const double so_far = left_.unnamed[j];
    return left <= without_share(left_.folds[j], has_unnamed(j) ? so_far : limits_.unnamed_share);
  }

  const DiagnosisState& x_;
  const Diagnosis& d_;
  const Thresholds& limits_;
  const UnexplainedError& left_;
};

}  // namespace

bool withdraw_names(DiagnosisState& x, const UnexplainedError& left) {
  if (x.d.changes) return false;
  auto found = Withdrawal(x, left).run();
  if (!found) return false;
  auto& [lost, without] = *found;
  withdraw(x, lost);
  auto& findings = x.d.findings;
  findings.erase(std::remove_if(findings.begin(), findings.end(),
                                [](const Finding& f) { return f.shape.has_value(); }),
                 findings.end());
  x.d.joints.clear();
  x.d.extended = std::move(without);
  return true;
}

void withdraw_contradicted(DiagnosisState& x) {
  const Diagnosis& d = x.d;
  Reasons lost;
  for (size_t k = 0; k < d.findings.size(); ++k) {
    const Finding& f = d.findings[k];
    const bool named = std::holds_alternative<NewEffect>(f.cause) || std::holds_alternative<ChannelError>(f.cause);
    if (f.shape || !f.joint || f.status != FindingStatus::kNotConfirmed || !named) continue;
    if (has_curve(d, f.joint->value))
      lost[k] = "held-out parts of the training recordings contradict it beside what has no name on its joint";
    else if (!d.changes && d.joints[f.joint->value].state == JointState::kAtFloor)
      lost[k] = "held-out parts of the training recordings contradict it, and its joint is at its floor";
  }
  withdraw(x, lost);
}

}  // namespace veridyn
