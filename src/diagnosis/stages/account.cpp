#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "diagnosis/evidence/held_out.hpp"
#include "diagnosis/findings/finding_words.hpp"
#include "diagnosis/findings/next_experiment.hpp"
#include "diagnosis/findings/right_to_a_name.hpp"
#include "diagnosis/stages/account.hpp"
#include "diagnosis/unnamed/shared_residual.hpp"
#include "diagnosis/unnamed/vibration.hpp"
#include "math/parallel.hpp"
#include "math/signed_rank.hpp"
#include "veridyn/effects/cause.hpp"

// Accounts for the residual after all tests: its predictable part, the signals on which it depends,
// and the verdict on every joint.

namespace veridyn {
namespace {

using numerics::kPercent;

bool acts_on(const Finding& f, int joint) {
  return f.status == FindingStatus::kConfirmed && (!f.joint || f.joint->value == joint);
}

// The share is that of the held-out recordings where they bear it out.
std::string phrase_of(const UnnamedShape& shape, double of_folds, Agreement held_out) {
  const bool measured = held_out == Agreement::kAgrees;
  std::string out = fmt::format("{:.0f} % of what the model leaves over {}can be predicted from {}: {}",
                                kPercent * (measured ? shape.share : of_folds), measured ? "" : "in training ",
                                signal_words(shape.signals), shape.words);
  if (!shape.as_good.empty()) {
    std::string others;
    for (const auto& names : shape.as_good) others += (others.empty() ? "" : ", ") + signal_words(names);
    out += " (as well from " + others + ": these recordings cannot tell)";
  }
  return out + "; nothing on the list has that shape";
}

class Account {
 public:
  explicit Account(DiagnosisState& x)
      : x_(x),
        d_(x.d),
        limits_(x.options.thresholds),
        left_{x.fold_errors(d_.extended).relative(), {}, motion_signals(d_.extended, limits_)},
        train_(motion_rows(d_.extended, d_.extended.train, d_.excluded_intervals, left_.signals)),
        test_(motion_rows(d_.extended, d_.extended.test, d_.excluded_intervals, left_.signals)) {
    left_.unnamed.assign(static_cast<size_t>(left_.folds.size()), 0.0);
  }

  // Adds findings without a name and the verdicts.
  UnexplainedError run() {
    const int n = d_.extended.model->joints();
    std::vector<Dependence> found(n);
    std::vector<std::vector<SmoothTerm>> terms(n);
    parallel_for(n, x_.options.identification.threads, [&](int j) {
      const auto at = static_cast<size_t>(j);
      terms[at] = smooth_terms(left_.signals, j, limits_);
      found[at] = find_dependence(j, train_, test_, terms[at], limits_);
    });
    std::vector<double> left;
    for (int j = 0; j < n; ++j) left.push_back(add_findings(found[j], terms[j]));
    std::vector<double> named;
    for (int j = 0; j < n; ++j) named.push_back(held_out_error(x_, d_.extended, j));
    for (int j = 0; j < n; ++j)
      d_.joints.push_back(verdict_of(j, found[j], named[j], left[j]));
    return std::move(left_);
  }

 private:
  // Findings of a joint's dependence; the held-out error that is left after them.
  double add_findings(const Dependence& found, const std::vector<SmoothTerm>& terms) {
    const int j = found.joint;
    const double before = held_out_error(x_, d_.extended, j);
    double error = before;
    if (!is_clear(found, x_) || !x_.options.effects.empty()) return error;
    double& so_far = left_.unnamed[j];
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
      f.folds_before = f.folds_after = left_.folds;
      f.folds_before[j] = without_share(left_.folds[j], so_far);
      f.folds_after[j] = without_share(left_.folds[j], share);
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

  JointVerdict verdict_of(int j, const Dependence& found, double extended, double left) const {
    if (x_.silent.count(j) != 0) return no_torque_verdict({j});
    const double error = held_out_error(x_, d_.baseline, j);
    if (!std::isfinite(error)) return not_judged({j}, error, d_.baseline);
    JointVerdict v;
    v.joint = JointIndex{j};
    v.held_out = error;
    v.extended = extended;
    const bool repeats = d_.baseline.noise_floor.size() > j;
    v.source = repeats ? FloorSource::kRepeats : FloorSource::kRegression;
    v.floor = std::min(v.held_out, repeats ? std::min(d_.baseline.noise_floor[j], left) : left);
    const bool unnamed = has_curve(d_, j);
    const std::optional<Vibration> vibration = vibration_of(d_.extended, j, limits_);
    if (vibration && !unnamed && without_share(left, vibration->share) < v.floor) {
      v.floor = without_share(left, vibration->share);
      v.source = FloorSource::kRegression;
    }
    // What signals predict and nobody asked about is no floor.
    const bool unasked = !x_.options.effects.empty() && is_clear(found, x_);
    if (unasked) v.floor = std::min(v.floor, without_share(left, std::max(0.0, found.predicted_of_test.back())));
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
    } else if (at_floor && !unasked && v.held_out <= limits_.at_floor * v.floor) {
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
    if (!x_.options.effects.empty() && is_clear(found, x_)) {
      return fmt::format("not all causes were asked about; signals of the motion predict {:.0f} % of what is left over",
                         kPercent * std::max(0.0, found.predicted_of_test.back()));
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
  UnexplainedError left_;
  MotionRows train_, test_;
};

// Errors along the way are of fits without physical conditions, and names were withdrawn since: the
// last step ends at the error of the extended model, and what it gains is measured from there.
void end_the_steps(DiagnosisState& x) {
  Diagnosis& d = x.d;
  Finding* last = nullptr;
  for (size_t k = 0; k < d.findings.size(); ++k) {
    Finding& f = d.findings[k];
    const bool selected = std::holds_alternative<NewEffect>(f.cause) || std::holds_alternative<ChangedEffect>(f.cause) ||
                          std::holds_alternative<AddedLoad>(f.cause);
    if (selected && !f.shape && f.status == FindingStatus::kConfirmed && f.test_after.size() > 0 &&
        x.fitted_by_start.count(k) == 0)
      last = &f;
  }
  if (last == nullptr || d.extended.test_error.relative.size() == 0) return;
  last->test_after = d.extended.test_error.relative;
  last->explains = explained_share(last->test_before, last->test_after, d.baseline);
}

}  // namespace

double without_share(double error, double share) {
  return error * std::sqrt(std::max(0.0, 1.0 - share));
}

std::string signal_words(const std::vector<std::string>& signals) {
  std::string out;
  for (const std::string& name : signals) out += (out.empty() ? "" : " and ") + name;
  return out;
}

bool is_clear(const Dependence& found, const DiagnosisState& x) {
  const Thresholds& limits = x.options.thresholds;
  const double least = x.d.provisional ? limits.unnamed_share_of_one : limits.unnamed_share;
  return !found.model.chosen.empty() && found.predicted_of_folds.back() > least;
}

double held_out_error(const DiagnosisState& x, const Identification& id, int joint) {
  const bool left_out = x.saturated.count(joint) > 0 && id.test_without_excluded.relative.size() > joint;
  const VectorXd& relative = (left_out ? id.test_without_excluded : id.test_error).relative;
  return relative.size() > joint ? relative[joint] : std::numeric_limits<double>::quiet_NaN();
}

void account_for_errors(DiagnosisState& x) {
  x.d.joints.clear();
  if (!x.d.extended.model) return;
  UnexplainedError left = Account(x).run();
  if (x.options.extended == ExtendedModel::kConfirmedOnly) {
    for (int turn = 0; turn < x.options.thresholds.withdrawals && withdraw_names(x, left); ++turn) left = Account(x).run();
    withdraw_contradicted(x);
  }
  end_the_steps(x);
  if (x.options.unnamed == UnnamedForces::kKept) keep_tables(x, left);
  x.d.next_experiment = next_experiment(x.d);
}

}  // namespace veridyn
