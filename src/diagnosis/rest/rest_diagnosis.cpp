#include "veridyn/diagnosis/rest_diagnosis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "diagnosis/candidates.hpp"
#include "diagnosis/findings/finding_words.hpp"
#include "diagnosis/findings/held_out.hpp"
#include "diagnosis/findings/summary.hpp"
#include "diagnosis/numerics.hpp"
#include "diagnosis/preparation/diagnosis_state.hpp"
#include "diagnosis/rest/position_curves.hpp"
#include "identification/fold_errors.hpp"
#include "math/parallel.hpp"
#include "math/student_t.hpp"
#include "veridyn/effects/effect_facts.hpp"

namespace veridyn {
namespace {

// Effects with a force at rest. Waves along the travel are excluded: their wave numbers come from a spectrum,
// which poses do not give.
std::vector<std::string> forces_of_position() {
  std::vector<std::string> out;
  for (const AxisEffect* effect : axis_effects()) {
    const EffectTraits traits = effect->traits();
    const std::vector<EffectShape> shapes = effect->shapes();
    const bool waves = std::any_of(shapes.begin(), shapes.end(), [](const EffectShape& shape) {
      return shape.scale == ShapeScale::kWaves;
    });
    if (traits.holds_at_rest && traits.depends_on_position && !traits.tabulated && !waves && !effect->imitates_others())
      out.push_back(effect->name());
  }
  return out;
}

struct RestQuestion {
  Candidate candidate;
  EffectTerm term;
};

// An arm fitted to the training poses, with its errors on parts of them that are predicted from the others.
struct RestFit {
  Identification id;
  FoldErrors folds;
};

class RestDiagnosis {
 public:
  RestDiagnosis(const Model& arm, const std::vector<RestPoses>& train, const std::vector<RestPoses>& test,
                const DiagnosisOptions& options)
      : arm_(arm), train_(train), test_(test), options_(options), limits_(options.thresholds) {
    for (const std::string& one : options.effects) wanted_.push_back(normalized_cause(arm, one));
  }

  Diagnosis run() {
    const auto begin = std::chrono::steady_clock::now();
    RestFit now = fitted({});
    d_.baseline = now.id;
    if (!now.id.model) return std::move(d_);
    d_.remarks = now.id.remarks;
    std::vector<RestQuestion> open = questions();
    d_.hypotheses = static_cast<int>(open.size());
    std::vector<EffectTerm> terms;
    while (static_cast<int>(d_.findings.size()) < options_.max_effects && !open.empty()) {
      std::vector<RestFit> fits(open.size());
      parallel_for(static_cast<int>(open.size()), options_.identification.threads, [&](int k) {
        std::vector<EffectTerm> with = terms;
        with.push_back(open[k].term);
        fits[k] = fitted(with);
      });
      std::optional<size_t> best;
      for (size_t k = 0; k < open.size(); ++k) {
        if (!is_supported(open[k], now, fits[k])) continue;
        if (!best || gain(now, fits[*best]) < limits_.tie * gain(now, fits[k])) best = k;
      }
      if (!best) break;
      add_finding(open[*best], now, fits[*best]);
      terms.push_back(open[*best].term);
      now = std::move(fits[*best]);
      open.erase(open.begin() + static_cast<long>(*best));
    }
    d_.extended = now.id;
    for (size_t k = 0; k < terms.size(); ++k) refresh(now.id, names_of(terms[k]), d_.findings[k]);
    if (d_.extended.remarks.size() > 1) d_.remarks.back() = d_.extended.remarks.back();  // the band that remains
    add_verdicts();
    summarize(d_, options_);
    d_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return std::move(d_);
  }

 private:
  // Lowest and highest position of a joint in the training poses.
  std::pair<double, double> range(int joint) const {
    double low = numerics::kHuge;
    double high = -numerics::kHuge;
    for (const RestPoses& poses : train_) {
      low = std::min(low, poses.q.col(joint).minCoeff());
      high = std::max(high, poses.q.col(joint).maxCoeff());
    }
    return {low, high};
  }

  std::vector<RestQuestion> questions() const {
    Scope scope;
    scope.wanted = forces_of_position();
    for (int i = 0; i < arm_.joints(); ++i) {
      const auto [low, high] = range(i);
      scope.still.push_back(high - low <= limits_.still(arm_.coordinates()[i].prismatic));
    }
    std::vector<RestQuestion> out;
    for (const Candidate& c : candidates(arm_, scope)) {
      if (!is_among(wanted_, arm_, c.cause)) continue;
      if (c.own || !c.joint || (c.axis.coefficients.array() != 0.0).count() != 1) continue;
      if (c.from && scope.still[c.from->value]) continue;
      EffectTerm term;
      term.effect = effect_of(c.cause);
      term.axis = c.axis;
      if (c.from) term.from = Axis{VectorXd::Unit(arm_.joints(), c.from->value), 0.0};
      const auto [low, high] = range(c.joint->value);
      for (const EffectShape& shape : find_effect(term.effect).shapes()) {
        if (shape.scale == ShapeScale::kMiddle) term.values[shape.name] = 0.5 * (low + high);
        if (shape.scale == ShapeScale::kTravel) term.values[shape.name] = 0.5 * (high - low);
      }
      out.push_back({c, std::move(term)});
    }
    return out;
  }

  RestFit fitted(const std::vector<EffectTerm>& terms) const {
    ModelDescription description = arm_.description();
    description.effects.insert(description.effects.end(), terms.begin(), terms.end());
    RestFit out;
    IdentificationOptions how = options_.identification;
    how.progress = {};
    out.id = identify_at_rest(Model(std::move(description)), train_, test_, how);
    if (!out.id.model) return out;
    how.weights = JointWeights::kRange;
    how.prior = *out.id.model;  // for parameters that no pose determines
    out.folds = fold_errors(out.id, how, hold_out(limits_));
    return out;
  }

  static double gain(const RestFit& before, const RestFit& after) {
    return -2.0 * (after.folds.relative().array().max(numerics::kTiny) / before.folds.relative().array().max(numerics::kTiny)).log().sum();
  }

  static double left_over(const RestFit& fit, int joint) {
    return fit.id.train_error.relative[joint] * fit.id.train_error.relative[joint];
  }

  // Poses are independent of each other, so that an F test holds.
  double p_value(const RestQuestion& q, const RestFit& before, const RestFit& after) const {
    double poses = 0.0;
    for (const RestPoses& some : train_) poses += static_cast<double>(some.poses());
    const int joint = q.candidate.joint->value;
    const auto count = static_cast<double>(find_effect(q.term.effect).parameters().size());
    const double freedom = std::max(1.0, poses - static_cast<double>(after.id.base.size()));
    const double f = (left_over(before, joint) / std::max(left_over(after, joint), numerics::kTiny) - 1.0) * freedom / count;
    return fisher_f_upper_tail(std::max(f, 0.0), count, freedom);
  }

  bool is_supported(const RestQuestion& q, const RestFit& before, const RestFit& after) const {
    if (!after.id.model || gain(before, after) <= limits_.smallest_gain) return false;
    const Eigen::Index joint = q.candidate.joint->value;
    const Eigen::Index better =
        (after.folds.error2.col(joint).array() < before.folds.error2.col(joint).array()).count();
    if (!hold_out(limits_).enough_agree(static_cast<size_t>(better), static_cast<size_t>(after.folds.error2.rows()))) return false;
    return p_value(q, before, after) < limits_.significance / static_cast<double>(d_.hypotheses);
  }

  std::vector<std::string> names_of(const EffectTerm& term) const {
    return EffectFacts(arm_, term).parameter_names();
  }

  void add_finding(const RestQuestion& q, const RestFit& before, const RestFit& after) {
    Finding f;
    f.cause = q.candidate.cause;
    f.joint = q.candidate.joint;
    const bool slides = arm_.coordinates()[f.joint->value].prismatic;
    for (const EffectParameter& p : find_effect(q.term.effect).parameters())
      f.parameters.push_back({p.name, slides ? p.unit_prismatic : p.unit_revolute, 0.0, 0.0, 0.0});
    f.unit = f.parameters.front().unit;
    f.gain = gain(before, after);
    f.p_value = p_value(q, before, after);
    f.test_before = before.id.test_error.relative;
    f.test_after = after.id.test_error.relative;
    f.folds_before = before.folds.relative();
    f.folds_after = after.folds.relative();
    f.status = status_of(f);
    f.explains = explained_share(f.test_before, f.test_after, d_.baseline);
    d_.findings.push_back(std::move(f));
  }

  // The error above the floor is the part that smooth functions of the positions predict on held-out poses.
  void add_verdicts() {
    const Identification& id = d_.extended;
    const VectorXd& before = d_.baseline.test_error.relative;
    const PositionCurves curves(id, limits_);
    for (int j = 0; j < arm_.joints(); ++j) {
      const double error = before.size() > j ? before[j] : std::numeric_limits<double>::quiet_NaN();
      if (!std::isfinite(error)) {
        d_.joints.push_back(not_judged({j}, error, d_.baseline));
        continue;
      }
      const double share = curves.predicted_share(j);
      const bool clear = share > limits_.unnamed_share;
      JointVerdict v;
      v.joint = JointIndex{j};
      v.held_out = error;
      v.extended = v.left = id.test_error.relative[j];
      v.floor = std::min(v.held_out, clear ? v.left * std::sqrt(1.0 - share) : v.left);
      v.removable = v.held_out - v.floor;
      const bool named = std::any_of(d_.findings.begin(), d_.findings.end(), [j](const Finding& f) {
        return f.joint->value == j;
      });
      v.state = clear ? JointState::kCannotTell : named ? JointState::kNamed : JointState::kAtFloor;
      if (clear)
        v.why = fmt::format("smooth functions of the positions predict {:.0f} % of what is left over, and {}", numerics::kPercent * share,
                            wanted_.empty() ? "no spring or cable has their shape" : "not all causes were asked about");
      d_.joints.push_back(std::move(v));
    }
  }

  const Model& arm_;
  const std::vector<RestPoses>& train_;
  const std::vector<RestPoses>& test_;
  const DiagnosisOptions& options_;
  const Thresholds& limits_;
  std::vector<std::string> wanted_;  // causes; empty: all
  Diagnosis d_;
};

}  // namespace

Diagnosis diagnose_at_rest(const Model& arm, const std::vector<RestPoses>& train,
                           const std::vector<RestPoses>& test, const DiagnosisOptions& options) {
  return RestDiagnosis(arm, train, test, options).run();
}

}  // namespace veridyn
