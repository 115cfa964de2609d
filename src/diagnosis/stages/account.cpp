#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "diagnosis/evidence/held_out.hpp"
#include "diagnosis/findings/finding_words.hpp"
#include "diagnosis/findings/next_experiment.hpp"
#include "diagnosis/findings/right_to_a_name.hpp"
#include "diagnosis/stages/diagnosis_state.hpp"
#include "diagnosis/unnamed/dependence.hpp"
#include "diagnosis/unnamed/shared_residual.hpp"
#include "diagnosis/unnamed/tables.hpp"
#include "diagnosis/unnamed/vibration.hpp"
#include "math/parallel.hpp"
#include "math/signed_rank.hpp"
#include "veridyn/effects/cause.hpp"

// Accounts for the residual after all tests: its predictable part, the signals on which it depends,
// and the verdict on every joint.

namespace veridyn {
namespace {

using numerics::kPercent;

double error_of(const VectorXd& relative, int joint) {
  return relative.size() > joint ? relative[joint] : std::numeric_limits<double>::quiet_NaN();
}

bool acts_on(const Finding& f, int joint) {
  return f.status == FindingStatus::kConfirmed && (!f.joint || f.joint->value == joint);
}

// The error with so much of its mean square predicted.
double without_share(double error, double share) {
  return error * std::sqrt(std::max(0.0, 1.0 - share));
}

std::string joined(const std::vector<std::string>& words, const char* between) {
  std::string out;
  for (const std::string& w : words) out += (out.empty() ? "" : between) + w;
  return out;
}

// The share is that of the held-out recordings where they bear it out.
std::string phrase_of(const UnnamedShape& shape, double of_folds, Agreement held_out) {
  const bool measured = held_out == Agreement::kAgrees;
  std::string out = fmt::format("{:.0f} % of what the model leaves over {}can be predicted from {}: {}",
                                kPercent * (measured ? shape.share : of_folds), measured ? "" : "in training ",
                                joined(shape.signals, " and "), shape.words);
  if (!shape.as_good.empty()) {
    std::vector<std::string> others;
    for (const auto& names : shape.as_good) others.push_back(joined(names, " and "));
    out += " (as well from " + joined(others, ", ") + ": these recordings cannot tell)";
  }
  return out + "; nothing on the list has that shape";
}

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

class Account {
 public:
  explicit Account(DiagnosisState& x)
      : x_(x),
        d_(x.d),
        limits_(x.options.thresholds),
        folds_(x.fold_errors(d_.extended).relative()),
        unnamed_(static_cast<size_t>(folds_.size()), 0.0),
        signals_(motion_signals(d_.extended, limits_)),
        train_(motion_rows(d_.extended, d_.extended.train, d_.excluded_intervals, signals_)),
        test_(motion_rows(d_.extended, d_.extended.test, d_.excluded_intervals, signals_)) {}

  // Withdraws names on joints with more than their floor: those small beside an unnamed dependence, which
  // biases them, and those without which smooth functions of signals that the effect does not act through
  // predict the held-out parts as well (an encompassing test, Mizon and Richard 1986). Joints that move as
  // one and a single recording leave open which signal it is. True if there were any.
  bool withdraw_names() {
    if (d_.changes) return false;
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
    if (!without) return false;
    withdraw(lost);
    d_.findings.erase(std::remove_if(d_.findings.begin(), d_.findings.end(),
                                     [](const Finding& f) { return f.shape.has_value(); }),
                      d_.findings.end());
    d_.joints.clear();
    d_.extended = std::move(*without);
    return true;
  }

  // Names that held-out parts contradict, beside a dependence that has none or where no error is left to name.
  void withdraw_contradicted() {
    Reasons lost;
    for (size_t k = 0; k < d_.findings.size(); ++k) {
      const Finding& f = d_.findings[k];
      const bool named = std::holds_alternative<NewEffect>(f.cause) || std::holds_alternative<ChannelError>(f.cause);
      if (f.shape || !f.joint || f.status != FindingStatus::kNotConfirmed || !named) continue;
      if (has_unnamed(f.joint->value))
        lost[k] = "held-out parts of the training recordings contradict it beside what has no name on its joint";
      else if (!d_.changes && d_.joints[f.joint->value].state == JointState::kAtFloor)
        lost[k] = "held-out parts of the training recordings contradict it, and its joint is at its floor";
    }
    withdraw(lost);
  }

  // Errors along the way are of fits without physical conditions, and names were withdrawn since: the
  // last step ends at the error of the extended model, and what it gains is measured from there.
  void end_the_steps() {
    Finding* last = nullptr;
    for (size_t k = 0; k < d_.findings.size(); ++k) {
      Finding& f = d_.findings[k];
      const bool selected = std::holds_alternative<NewEffect>(f.cause) || std::holds_alternative<ChangedEffect>(f.cause) ||
                            std::holds_alternative<AddedLoad>(f.cause);
      if (selected && !f.shape && f.status == FindingStatus::kConfirmed && f.test_after.size() > 0 &&
          x_.fitted_by_start.count(k) == 0)
        last = &f;
    }
    if (last == nullptr || d_.extended.test_error.relative.size() == 0) return;
    last->test_after = d_.extended.test_error.relative;
    last->explains = explained_share(last->test_before, last->test_after, d_.baseline);
  }

  // Findings without a name as tables of the extended model.
  void keep_tables() {
    std::vector<double> left;
    for (const JointVerdict& v : d_.joints) left.push_back(v.left);
    keep(left);
    for (const Finding& f : d_.findings) {
      if (!f.shape || f.shape->kept || f.status != FindingStatus::kConfirmed) continue;
      d_.remarks.push_back(fmt::format("Not in the model: the curve of joint {} over {}: {}.", f.joint->value + 1,
                                       joined(f.shape->signals, " and "), why_not_kept(f)));
    }
    for (JointVerdict& v : d_.joints) {
      v.left = left[v.joint.value];
      v.floor = std::min(v.floor, v.left);
      v.removable = v.held_out - v.floor;
    }
  }

  void run() {
    const int n = d_.extended.model->joints();
    std::vector<Dependence> found(n);
    std::vector<std::vector<SmoothTerm>> terms(n);
    parallel_for(n, x_.options.identification.threads, [&](int j) {
      const auto at = static_cast<size_t>(j);
      terms[at] = smooth_terms(signals_, j, limits_);
      found[at] = find_dependence(j, train_, test_, terms[at], limits_);
    });
    std::vector<double> left;
    for (int j = 0; j < n; ++j) left.push_back(add_findings(found[j], terms[j]));
    std::vector<double> named;
    for (int j = 0; j < n; ++j) named.push_back(held_out(d_.extended, j));
    for (int j = 0; j < n; ++j)
      d_.joints.push_back(verdict_of(j, found[j], named[j], left[j]));
  }

 private:
  using Reasons = std::map<size_t, const char*>;  // by index of a finding

  void withdraw(const Reasons& lost) {
    std::vector<Finding> kept;
    std::map<size_t, std::vector<std::string>> fitted_by_start;  // by the new indices
    std::vector<VectorXd> begins;  // errors before the names that go, held out and of folds
    for (size_t k = 0; k < d_.findings.size(); ++k) {
      Finding& f = d_.findings[k];
      const auto why = lost.find(k);
      const bool is_step = !f.shape && f.test_before.size() > 0;
      if (why == lost.end()) {
        if (is_step && !begins.empty()) begin_at(f, std::exchange(begins, {}));
        const auto names = x_.fitted_by_start.find(k);
        if (names != x_.fitted_by_start.end()) fitted_by_start.emplace(kept.size(), std::move(names->second));
        kept.push_back(std::move(f));
        continue;
      }
      if (is_step && begins.empty()) begins = {f.test_before, f.folds_before};
      d_.not_supported.insert(d_.not_supported.begin(), {f.cause, f.p_value, why->second});
      d_.remarks.push_back(fmt::format("Withdrawn: {} Not named, for {}.", d_.sentence(f), why->second));
    }
    d_.findings = std::move(kept);
    x_.fitted_by_start = std::move(fitted_by_start);
  }

  // The step of a finding begins where that of the names withdrawn before it began.
  void begin_at(Finding& f, const std::vector<VectorXd>& before) const {
    f.test_before = before[0];
    if (f.folds_before.size() == before[1].size()) f.folds_before = before[1];
    f.explains = explained_share(f.test_before, f.test_after, d_.baseline);
  }

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
    const double unnamed = unnamed_[j] * folds_[j] * folds_[j];
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
      return std::all_of(signals_.begin(), signals_.end(), [&](const MotionSignal& s) {
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
      return motion_rows(without, of, d_.excluded_intervals, signals_);
    };
    const std::vector<SmoothTerm> terms = smooth_terms(signals_, j, limits_);
    const Dependence found = find_dependence(j, rows(without.train), rows(without.test), terms, limits_);
    if (!is_clear(found)) return false;
    const std::vector<int>& main = terms[found.model.chosen.front().term].signals;
    const bool own = std::all_of(main.begin(), main.end(), [&](int s) {
      return acts_through(f, signals_[s]);
    });
    if (own && !has_another_shape(f)) return false;
    const double left = without_share(x_.fold_errors(without).relative()[j], found.predicted_of_folds.back());
    const double so_far = unnamed_[j];
    return left <= without_share(folds_[j], has_unnamed(j) ? so_far : limits_.unnamed_share);
  }

  // Held-out error of a joint; without rows at the limit of its torque, which no model of the arm predicts.
  double held_out(const Identification& id, int j) const {
    const bool left_out = x_.saturated.count(j) > 0 && id.test_without_excluded.relative.size() > j;
    return error_of((left_out ? id.test_without_excluded : id.test_error).relative, j);
  }

  // Findings of a joint's dependence; the held-out error that is left after them.
  double add_findings(const Dependence& found, const std::vector<SmoothTerm>& terms) {
    const int j = found.joint;
    const double before = held_out(d_.extended, j);
    double error = before;
    if (!is_clear(found) || !x_.options.effects.empty()) return error;
    double& so_far = unnamed_[j];
    double of_test = 0.0;
    error = without_share(before, std::max(0.0, found.predicted_of_test.back()));
    for (size_t k = 0; k < found.model.chosen.size(); ++k) {
      const double share = found.predicted_of_folds[k];
      if (share - so_far < limits_.unnamed_term) continue;  // in the regression, and too little to speak of
      UnnamedShape shape = shape_of(found, k, train_, terms, effort_unit(x_.arm.coordinates()[j]));
      Finding f;
      f.cause = NewEffect{UnnamedShape::kName, JointIndex{j}};
      f.joint = JointIndex{j};
      f.unit = shape.effort;
      f.gain = found.model.chosen[k].gain;
      f.p_value = signed_rank_p_value(found.model.falls);
      f.test_before = d_.extended.test_error.relative;
      f.test_after = f.test_before;
      f.folds_before = f.folds_after = folds_;
      f.folds_before[j] = without_share(folds_[j], so_far);
      f.folds_after[j] = without_share(folds_[j], share);
      if (f.test_before.size() > j) {
        f.test_before[j] = without_share(before, of_test);
        f.test_after[j] = without_share(before, found.predicted_of_test[k]);
      }
      f.status = status_of(f);
      // What is predicted of the difference between repeats is no noise.
      VectorXd floor = d_.baseline.noise_floor;
      if (floor.size() > j) floor[j] = std::min(floor[j], error);
      f.explains = explained_share(f.test_before, f.test_after, d_.baseline.test_error.relative, floor);
      shape.share = found.predicted_of_test[k] - of_test;
      f.phrase = phrase_of(shape, share - so_far, f.held_out());
      f.shape = std::move(shape);
      so_far = share;
      of_test = found.predicted_of_test[k];
      d_.findings.push_back(std::move(f));
    }
    return error;
  }

  bool has_unnamed(int joint) const { return has_curve(d_, joint); }

  std::vector<MotionSignal> signals_of(const Finding& f) const {
    std::vector<MotionSignal> out;
    for (const std::string& name : f.shape->signals) {
      out.push_back(*std::find_if(signals_.begin(), signals_.end(),
                                  [&name](const MotionSignal& s) { return s.name == name; }));
    }
    return out;
  }

  const char* why_not_kept(const Finding& f) const {
    return tables_of(x_.arm, *f.joint, *f.shape, signals_of(f)).empty()
               ? "a table holds signals of the joint itself and of one other, no accelerations, histories or times, and nothing in proportion to a torque"
               : "with it held-out parts are predicted no better";
  }

  // Adds tables of unnamed findings to the extended model and fits it again. A joint that it
  // predicts worse gets none.
  void keep(std::vector<double>& left) {
    std::vector<EffectTerm> tables;
    std::vector<size_t> of;
    for (size_t k = 0; k < d_.findings.size(); ++k) {
      const Finding& f = d_.findings[k];
      if (!f.shape || f.status != FindingStatus::kConfirmed) continue;
      for (EffectTerm& term : tables_of(x_.arm, *f.joint, *f.shape, signals_of(f))) {
        tables.push_back(std::move(term));
        of.push_back(k);
      }
    }
    std::set<int> worse;
    for (int turn = 0; turn < 2; ++turn) {
      const Identification with = fitted_with(tables, of, worse);
      if (!with.model) return;
      const VectorXd after = x_.fold_errors(with).relative();
      bool again = false;
      for (const size_t k : of) {
        const int j = d_.findings[k].joint->value;
        if (worse.count(j) == 0 && after[j] > folds_[j]) again = worse.insert(j).second;
      }
      if (again && turn == 0) continue;
      if (again) return;
      for (const size_t k : of) {
        const int j = d_.findings[k].joint->value;
        if (worse.count(j) != 0) continue;
        d_.findings[k].shape->kept = true;
        left[j] = held_out(with, j);
      }
      d_.extended = with;
      return;
    }
  }

  Identification fitted_with(const std::vector<EffectTerm>& tables, const std::vector<size_t>& of,
                             const std::set<int>& without) const {
    ModelDescription description = d_.extended.model->description();
    bool any = false;
    for (size_t t = 0; t < tables.size(); ++t) {
      if (without.count(d_.findings[of[t]].joint->value) != 0) continue;
      any = true;
      description.effects.push_back(tables[t]);
    }
    if (!any) return {};
    description.identified.reset();
    return x_.fit(Model(std::move(description)));
  }

  // What held-out parts of the training recordings show, and enough of it.
  bool is_clear(const Dependence& found) const {
    const double least = d_.provisional ? limits_.unnamed_share_of_one : limits_.unnamed_share;
    return !found.model.chosen.empty() && found.predicted_of_folds.back() > least;
  }

  JointVerdict verdict_of(int j, const Dependence& found, double extended, double left) const {
    const double error = held_out(d_.baseline, j);
    if (!std::isfinite(error)) return not_judged({j}, error, d_.baseline);
    JointVerdict v;
    v.joint = JointIndex{j};
    v.held_out = error;
    v.extended = extended;
    const bool repeats = d_.baseline.noise_floor.size() > j;
    v.source = repeats ? FloorSource::kRepeats : FloorSource::kRegression;
    v.floor = std::min(v.held_out, repeats ? std::min(d_.baseline.noise_floor[j], left) : left);
    const bool unnamed = has_unnamed(j);
    const std::optional<Vibration> vibration = vibration_of(d_.extended, j, limits_);
    if (vibration && !unnamed && without_share(left, vibration->share) < v.floor) {
      v.floor = without_share(left, vibration->share);
      v.source = FloorSource::kRegression;
    }
    v.removable = v.held_out - v.floor;
    v.left = left;
    // What is wrong on one joint can bend the parameters of the others: a name there explains this joint's error if
    // nothing is left of it.
    const bool at_floor = left <= limits_.at_floor * v.floor;
    const bool gone = at_floor && v.held_out > limits_.at_floor * v.floor;
    const bool named = std::any_of(d_.findings.begin(), d_.findings.end(), [&](const Finding& f) {
      return !f.shape && (gone || acts_on(f, j));
    });
    const bool mostly = v.held_out - v.extended > 0.5 * v.removable;
    if (named && v.extended < v.held_out && (mostly || (at_floor && !unnamed))) {
      v.state = JointState::kNamed;
    } else if (unnamed) {
      v.state = JointState::kUnnamed;
    } else if (at_floor && v.held_out <= limits_.at_floor * v.floor) {
      v.state = JointState::kAtFloor;
    } else {
      v.state = JointState::kCannotTell;
      v.why = vibration ? words_of(*vibration, j) : words_of_steps(j) + why_not(found, repeats) + words_of_shared(j);
    }
    return v;
  }

  std::string words_of(const Vibration& vibration, int j) const {
    return fmt::format("{:.0f} % of what is left over is a vibration of {:.3g} Hz and {:.3g} {} that the motion does "
                       "not have: something shakes the arm, or a part of it swings",
                       kPercent * vibration.share, vibration.frequency, vibration.amplitude,
                       effort_unit(x_.arm.coordinates()[j]));
  }

  // Coarse steps of a recorded torque, which no model predicts.
  std::string words_of_steps(int j) const {
    for (const RecordingQuality& q : d_.data_quality) {
      const QualityFinding* steps = q.find("torque_quantised", j + 1);
      if (steps == nullptr) continue;
      return fmt::format("its torque is recorded in steps of {:.3g} {}; ", steps->value,
                         steps->signal == "tau" ? effort_unit(x_.arm.coordinates()[j]) : steps->unit);
    }
    return "";
  }

  std::string words_of_shared(int j) const {
    const std::optional<SharedResidual> shared = shared_residual(train_, j, limits_);
    if (!shared) return "";
    return fmt::format("; it goes together with what is left over on joint {} (correlation {:.2f} in training, of one sign "
                       "in every part): one cause may act on both, as what the arm stands on or carries does",
                       shared->with + 1, shared->correlation);
  }

  std::string why_not(const Dependence& found, bool repeats) const {
    if (!x_.options.effects.empty() && is_clear(found)) {
      return fmt::format("not all causes were asked about; signals of the motion predict {:.0f} % of what is left over",
                         kPercent * found.predicted_of_test.back());
    }
    if (!found.model.chosen.empty()) {
      return fmt::format("the training recordings predict {:.0f} % of what is left over, the held-out ones {:.0f} %",
                         kPercent * found.predicted_of_folds.back(),
                         kPercent * std::max(0.0, found.predicted_of_test.back()));
    }
    if (repeats)
      return "it comes back with the motion, yet no signal of the recordings predicts it on rows that were held out";
    return "what the findings leave over is no function of one or two signals of the recordings, nor of positions times a torque";
  }

  DiagnosisState& x_;
  Diagnosis& d_;
  const Thresholds& limits_;
  VectorXd folds_;               // error of the extended model on held-out parts of the training recordings
  std::vector<double> unnamed_;  // share of its square that findings without a name predict there, (n)
  std::vector<MotionSignal> signals_;
  MotionRows train_, test_;
};

}  // namespace

void account_for_errors(DiagnosisState& x) {
  x.d.joints.clear();
  if (!x.d.extended.model) return;
  std::optional<Account> account(std::in_place, x);
  account->run();
  for (int turn = 0; turn < x.options.thresholds.withdrawals && x.options.extended == ExtendedModel::kConfirmedOnly && account->withdraw_names(); ++turn) {
    account.emplace(x);
    account->run();
  }
  if (x.options.extended == ExtendedModel::kConfirmedOnly) account->withdraw_contradicted();
  account->end_the_steps();
  if (x.options.unnamed == UnnamedForces::kKept) account->keep_tables();
  x.d.next_experiment = next_experiment(x.d);
}

}  // namespace veridyn
