#include "diagnosis/search/explain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "diagnosis/search/row_constants.hpp"
#include "diagnosis/findings/held_out.hpp"
#include "diagnosis/numerics.hpp"
#include "diagnosis/findings/finding_words.hpp"
#include "diagnosis/findings/next_experiment.hpp"
#include "diagnosis/search/moments.hpp"
#include "diagnosis/search/numbers.hpp"
#include "diagnosis/search/tables.hpp"
#include "diagnosis/search/vibration.hpp"
#include "identification/differing_recordings.hpp"
#include "math/student_t.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/effects/effect_facts.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn::search {
namespace {

// Sum of the logarithms of the joints' errors, as in the score; joints without a positive error do not count.
double log_sum(const VectorXd& error) {
  double out = 0.0;
  for (const double e : error) out += e > 0.0 ? std::log(e) : 0.0;
  return out;
}

// Joints that have no friction of their own in the file.
std::set<int> joints_without_friction(const Model& arm) {
  std::set<int> out;
  for (int i = 0; i < arm.joints(); ++i) {
    const bool has = std::any_of(arm.effects().begin(), arm.effects().end(), [&](const EffectTerm& term) {
      return is_friction(term.effect) && std::abs(term.axis.coefficients[i]) > kAlongJoint * term.axis.coefficients.norm();
    });
    if (!has) out.insert(i);
  }
  return out;
}

// Sum of the magnitudes of a joint's frictions [N m] or [N] at a speed [rad/s] or [m/s].
double friction_at(const Model& arm, int joint, double speed) {
  const VectorXd still = VectorXd::Zero(arm.joints()), dq = speed * VectorXd::Unit(arm.joints(), joint);
  double out = 0.0;
  for (const EffectTerm& term : arm.effects()) {
    if (!is_friction(term.effect) || std::abs(term.axis.coefficients[joint]) < kAlongJoint * term.axis.coefficients.norm()) continue;
    const EffectFacts effect(arm, term);
    out += std::abs(effect.force_at(effect.sample(0.0, still.data(), dq.data(), still.data(), 1)));
  }
  return out;
}

// Runs the search for a diagnosis and writes its results into the state.
class Explanation {
 public:
  explicit Explanation(DiagnosisState& x) : x_(x), d_(x.d), n_(x.arm.joints()) {}

  void write() {
    SearchRequest request;
    request.scope.changes = d_.changes;
    // Known values that were not fitted to a recording may have wrong constants and no friction.
    request.scope.constants = !d_.changes || !x_.arm.description().identified;
    request.scope.wanted = x_.options.effects;
    request.scope.silent = x_.silent;
    request.scope.poses = x_.poses;
    request.recordings = x_.train;
    for (const CompressedRecording& r : x_.start.factors) request.periods.push_back(r.period.seconds);
    request.preprocessing = x_.options.identification.preprocessing;
    request.test = x_.test;
    request.test_preprocessing = x_.options.identification.test_preprocessing.value_or(request.preprocessing);
    request.test_preprocessing.stale_rows = StaleRows::kKept;
    request.test_preprocessing.excluded_intervals.clear();
    if (request.scope.constants) request.without_friction = joints_without_friction(*x_.start.model);
    request.most = x_.options.max_effects + static_cast<int>(3 * request.without_friction.size());
    request.threads = x_.options.identification.threads;
    request.progress = x_.options.testing;
    found_ = search(*x_.start.model, request);
    d_.hypotheses = found_.tested_terms;
    d_.remarks = x_.remarks;
    weigh_rows();
    add_findings();
    erase_zeros();
    fit();
    add_contacts();
    add_rejected_causes();
    keep_tables();
    for (int j = 0; j < n_; ++j) d_.joints.push_back(verdict_of(j));
    d_.next_experiment = next_experiment(d_);
  }

 private:
  // The fit under physical conditions weighs rows as the search did.
  void weigh_rows() {
    for (size_t r = 0; r < x_.train.size() && found_.weights.rows() > 0; ++r) {
      auto weights = std::make_shared<SampleWeights>();
      std::vector<Eigen::Index> own;
      for (Eigen::Index k = 0; k < found_.rows->rows(); ++k) {
        if (found_.rows->recording()[k] != r) continue;
        own.push_back(k);
        weights->time.push_back(found_.rows->time()[k]);
      }
      weights->of_joint = found_.weights(own, Eigen::all);
      x_.options.identification.preprocessing.weights[x_.train[r]] = std::move(weights);
    }
  }

  // Several memories or waves of one cause on one axis form one finding.
  void add_findings() {
    std::map<std::string, size_t> known;
    for (size_t k = 0; k < found_.chosen.size(); ++k) {
      const Chosen& c = found_.chosen[k];
      Finding f = finding_of(c, found_, *x_.start.model);
      f.test_before = test_error(k);
      f.test_after = test_error(k + 1);
      const auto at = known.find(c.term.place);
      if (at != known.end() && c.term.kind != TermKind::kCurve) {
        Finding& own = d_.findings[at->second];
        ++count_[at->second];
        for (FoundParameter& p : f.parameters) {
          p.name += fmt::format("_{}", count_[at->second]);
          own.parameters.push_back(std::move(p));
        }
        own.phrase += "; " + f.phrase;
        own.gain += f.gain;
        of_finding_[at->second].push_back(k);
        continue;
      }
      known.emplace(c.term.place, d_.findings.size());
      count_.push_back(1);
      of_finding_.push_back({k});
      d_.findings.push_back(std::move(f));
    }
  }

  // Test error with the first `terms` terms, scaled by the residual of the fit without physical conditions,
  // so that fits with and without these conditions begin with the same error.
  VectorXd test_error(size_t terms) const {
    const VectorXd& base = d_.baseline.test_error.relative;
    if (base.size() == 0 || found_.test_error.rows() == 0) return base;
    VectorXd out = base;
    for (int j = 0; j < n_; ++j) {
      const double before = found_.test_error(0, j);
      if (before > 0.0) out[j] = base[j] * found_.test_error(static_cast<Eigen::Index>(terms), j) / before;
    }
    return out;
  }

  // Chosen terms of all findings but these, curves excluded.
  std::vector<Chosen> named_terms(const std::set<size_t>& without = {}) const {
    std::vector<Chosen> out;
    for (size_t f = 0; f < of_finding_.size(); ++f) {
      for (const size_t k : of_finding_[f]) {
        if (found_.chosen[k].term.kind != TermKind::kCurve && without.count(f) == 0) out.push_back(found_.chosen[k]);
      }
    }
    return out;
  }

  // The arm without the findings. For a MODEL it includes the shift of its parameters, within their
  // covariance, that the findings cause.
  Model before() const {
    return d_.changes && found_.values.size() > 0 ? with_values(*x_.start.model, found_.values, VectorXd()) : *x_.start.model;
  }

  // True if the interval of every value of a term holds zero. The values of a tilt are relative to its own gravity; the constant
  // torque of a spring without stiffness is no spring.
  bool may_be_zero(const Chosen& c) const {
    if (c.term.kind == TermKind::kCurve || c.gravity) return false;
    const double t = student_t_quantile(numerics::kOutside, static_cast<double>(found_.degrees_of_freedom));
    const Eigen::Index count = c.values.size() - static_cast<Eigen::Index>(c.term.with_rest);
    return (c.values.head(count).array().abs() <= t * c.deviations.head(count).array()).all();
  }

  // What may be zero is no finding, even if its place in the set gains something: another term of the set has its torque. A
  // level that differs from day to day stays, because the MODEL's own values explain it only at the cost of their prior.
  void erase_zeros() {
    for (size_t f = of_finding_.size(); f-- > 0;) {
      const std::vector<size_t>& own = of_finding_[f];
      if (!std::all_of(own.begin(), own.end(), [&](size_t k) { return may_be_zero(found_.chosen[k]); })) continue;
      if (found_.chosen[own.front()].term.is_daily) d_.findings[f].remark = "Within their uncertainty, other values of the model may explain it as well.";
      else drop_finding(f, "beside the other findings the 95 % interval of each of its values holds zero");
    }
  }

  // Fits the arm with all named terms under physical conditions. A term whose size ends at its bound is
  // dropped.
  void fit() {
    std::set<size_t> gone;
    for (size_t turn = 0; turn <= of_finding_.size(); ++turn) {
      const std::vector<Chosen> some = named_terms(gone);
      d_.extended = some.empty() && x_.start.model ? x_.start : x_.fit(extended_arm(before(), some, d_.changes));
      if (!d_.extended.model || d_.changes || some.empty()) break;
      // If the named terms increase the error under physical conditions, the weakest one is dropped.
      if (log_sum(d_.extended.train_error.relative) > log_sum(d_.baseline.train_error.relative)) {
        for (size_t f = of_finding_.size(); f-- > 0;) {
          if (found_.chosen[of_finding_[f].front()].term.kind != TermKind::kCurve && gone.insert(f).second) break;
        }
        continue;
      }
      bool again = false;
      for (size_t f = 0; f < of_finding_.size(); ++f) {
        const Chosen& c = found_.chosen[of_finding_[f].front()];
        if (gone.count(f) != 0 || c.term.kind != TermKind::kEffect || of_finding_[f].size() > 1) continue;
        const EffectFacts facts(*d_.extended.model, c.term.effect);
        refresh(d_.extended, facts.parameter_names(), d_.findings[f]);
        bool is_something = false;
        for (int p = 0; p < facts.parameter_count(); ++p) {
          const FoundParameter& own = d_.findings[f].parameters[p];
          is_something = is_something || own.low > 0.0 || own.high < 0.0;
        }
        if (!is_something) again = gone.insert(f).second || again;
      }
      if (!again) break;
    }
    if (!d_.extended.model) {
      d_.remarks.push_back("The arm with what was found could not be identified: " + d_.extended.reason);
      d_.extended = x_.start;
    }
    for (auto f = gone.rbegin(); f != gone.rend(); ++f) drop_finding(*f, "with it a physically possible arm is predicted no better");
    size_t last = 0;
    bool any = false;
    for (size_t f = 0; f < of_finding_.size(); ++f) {
      if (d_.findings[f].shape) continue;
      last = f;
      any = true;
    }
    // The last finding ends at the error of the extended model.
    if (any && d_.extended.test_error.relative.size() > 0) d_.findings[last].test_after = d_.extended.test_error.relative;
    left_ = d_.extended.test_error.relative;
    if (left_.size() == n_ && found_.test_error.rows() > 0) {
      const auto names = static_cast<Eigen::Index>(std::count_if(found_.chosen.begin(), found_.chosen.end(), [](const Chosen& c) { return c.term.kind != TermKind::kCurve; }));
      for (size_t f = 0, k = static_cast<size_t>(names); f < d_.findings.size(); ++f) {
        Finding& curve = d_.findings[f];
        if (!curve.shape) continue;
        curve.test_before = curve.test_after = left_;
        const int j = curve.joint->value;
        const double before = found_.test_error(static_cast<Eigen::Index>(k), j);
        if (before > 0.0) curve.test_after[j] *= found_.test_error(static_cast<Eigen::Index>(k) + 1, j) / before;
        left_ = curve.test_after;
        ++k;
      }
    }
    // The part of the difference between repeats that curves predict is no noise.
    VectorXd floor = d_.baseline.noise_floor;
    if (floor.size() == n_ && left_.size() == n_) floor = floor.cwiseMin(left_);
    for (Finding& f : d_.findings) f.explains = explained_share(f.test_before, f.test_after, d_.baseline.test_error.relative, floor);
  }

  void drop_finding(size_t f, const char* reason) {
    d_.not_supported.push_back({d_.findings[f].cause, d_.findings[f].p_value, reason});
    d_.findings.erase(d_.findings.begin() + static_cast<long>(f));
    of_finding_.erase(of_finding_.begin() + static_cast<long>(f));
    count_.erase(count_.begin() + static_cast<long>(f));
  }

  // True if the recorded torque of the contact's last joint was at its limit at that time.
  bool is_at_limit(const Contact& c) const {
    return std::any_of(d_.data_quality.begin(), d_.data_quality.end(), [&c](const RecordingQuality& q) {
      return q.file == c.source && std::any_of(q.saturated.begin(), q.saturated.end(), [&c](const SaturatedInterval& at) {
               return at.joint.value == c.last_joint && at.from < c.to && c.from < at.to;
             });
    });
  }

  // True if the joint rests or turns back meanwhile, and its dry friction, of whatever sign, has this size.
  bool is_dry_friction(const Contact& c) const {
    const auto at = std::find(x_.train.begin(), x_.train.end(), c.source);
    const Rows& rows = at != x_.train.end() ? *found_.rows : *found_.test;
    const auto recording = static_cast<size_t>(at != x_.train.end() ? at - x_.train.begin() : std::find(x_.test.begin(), x_.test.end(), c.source) - x_.test.begin());
    double sum = 0.0, count = 0.0, fastest = 0.0;
    for (const Stretch& s : rows.stretches()) {
      for (size_t k = 0; s.recording == recording && k < s.kept.size(); ++k) {
        const double speed = std::abs(s.segment.dq(s.kept[k], c.last_joint)), time = rows.time()[s.first + static_cast<Eigen::Index>(k)];
        fastest = std::max(fastest, speed);
        if (time < c.from || time > c.to) continue;
        sum += speed;
        count += 1.0;
      }
    }
    const double rest = kRestShare * fastest;
    return count > 0.0 && sum / count <= rest && d_.extended.model && std::abs(c.effort[c.last_joint]) <= friction_at(*d_.extended.model, c.last_joint, rest);
  }

  // [s] of the motion of every recording; 0: it does not repeat.
  static std::vector<double> periods(const std::vector<RecordingError>& recordings) {
    std::vector<double> out;
    for (const RecordingError& r : recordings) out.push_back(r.period);
    return out;
  }

  void add_contacts() {
    const bool has_room = static_cast<int>(named_terms().size()) < x_.options.max_effects;
    if (x_.poses || !x_.tests_effect(ExternalContact::kName) || !has_room || found_.fitted.rows() == 0) return;
    std::vector<Contact> contacts;
    add_moments_in(*found_.rows, found_.fitted, found_.scale, x_.train, periods(d_.baseline.train), contacts);
    if (found_.test) add_moments_in(*found_.test, found_.test_residual, found_.scale, x_.test, periods(d_.baseline.test), contacts);
    // The residual of a joint with an unnamed curve is no push.
    contacts.erase(std::remove_if(contacts.begin(), contacts.end(), [&](const Contact& c) {
                     const bool has_curve = std::any_of(found_.chosen.begin(), found_.chosen.end(), [&c](const Chosen& t) {
                       return t.term.kind == TermKind::kCurve && t.term.joint->value == c.last_joint;
                     });
                     return has_curve || is_at_limit(c) || is_dry_friction(c) || !x_.tests_cause(ExternalContact{JointIndex{c.last_joint}});
                   }), contacts.end());
    if (contacts.empty()) return;
    leave_out(excluded_intervals(contacts), x_);
    auto& weights = x_.options.identification.preprocessing.weights;
    const auto kept = std::exchange(weights, {});
    const Identification without = x_.fit(x_.arm);
    weights = kept;
    if (without.model) d_.baseline = without;
    const Identification extended = x_.fit(extended_arm(before(), named_terms(), d_.changes));
    if (extended.model) d_.extended = extended;
    std::vector<Finding> found = findings_of(contacts, d_.baseline);
    d_.findings.insert(d_.findings.begin(), std::make_move_iterator(found.begin()), std::make_move_iterator(found.end()));
  }

  void add_rejected_causes() {
    std::set<std::string> unseen;
    for (const Rejected& r : found_.rejected) {
      const bool is_found = std::any_of(found_.chosen.begin(), found_.chosen.end(), [&r](const Chosen& c) { return same_place(c.term, r.term); });
      if (is_found) continue;  // there may be several memories
      if (r.collinear) {
        if (unseen.insert(to_text(x_.arm, r.term.cause)).second)
          d_.cannot_tell.push_back({effect_of(r.term.cause), r.term.cause, "its torque is a combination of parameters that the model has already, or it never acts in these recordings"});
        continue;
      }
      const double p = r.error > 0.0 ? 0.5 * std::erfc(r.gain / r.error / std::sqrt(2.0)) : 1.0;
      d_.not_supported.push_back({r.term.cause, p, r.impossible ? "its value would have an impossible sign or size"
                                                   : r.gain <= 0.0 ? "held-out data are predicted no better"
                                                                   : "held-out data gain too little from it"});
    }
    if (!d_.changes) d_.cannot_tell.push_back({AddedLoad::kName, std::nullopt, "without a model from before, a load is part of the link it sits on"});
  }

  // Adds curves as tables to the extended model, if the options ask for tables.
  void keep_tables() {
    if (x_.options.unnamed != UnnamedForces::kKept || !d_.extended.model) return;
    ModelDescription description = d_.extended.model->description();
    std::vector<Finding*> kept;
    for (size_t f = 0; f < d_.findings.size(); ++f) {
      Finding& finding = d_.findings[f];
      if (!finding.shape) continue;
      const std::vector<EffectTerm> tables = tables_of(x_.arm, *finding.joint, *finding.shape, signals_of(finding));
      if (tables.empty()) {
        d_.remarks.push_back(fmt::format("Not in the model: the curve of joint {} over {}: a table holds signals of the joint itself and of one other, "
                                         "no torques, histories or times.",
                                         finding.joint->value + 1, fmt::join(finding.shape->signals, " and ")));
        continue;
      }
      description.effects.insert(description.effects.end(), tables.begin(), tables.end());
      kept.push_back(&finding);
    }
    if (kept.empty()) return;
    description.identified.reset();
    Identification with = x_.fit(Model(std::move(description)));
    if (!with.model) return;
    d_.extended = std::move(with);
    for (Finding* f : kept) f->shape->kept = true;
    left_ = d_.extended.test_error.relative;
  }

  std::vector<MotionSignal> signals_of(const Finding& f) const {
    const std::vector<MotionSignal> all = motion_signals(d_.extended, x_.options.thresholds);
    std::vector<MotionSignal> out;
    for (const std::string& name : f.shape->signals) {
      const auto at = std::find_if(all.begin(), all.end(), [&](const MotionSignal& s) { return s.name == name; });
      if (at != all.end()) out.push_back(*at);
    }
    return out;
  }

  // Relative held-out error of joint j; NaN if it was not measured. Rows at a torque limit do not count.
  double held_out_error(const Identification& id, int j) const {
    const bool left_out = x_.saturated.count(j) > 0 && id.test_without_excluded.relative.size() > j;
    const VectorXd& relative = (left_out ? id.test_without_excluded : id.test_error).relative;
    return relative.size() > j ? relative[j] : std::numeric_limits<double>::quiet_NaN();
  }

  // Relative error of the arm as it is. A MODEL's values are fitted to none of the recordings, so that a change since it was
  // made raises the errors of all of them.
  double least_error(int j) const {
    const double held_out = held_out_error(d_.baseline, j);
    const VectorXd& trained = d_.baseline.train_error.relative;
    return d_.changes && trained.size() > j ? std::min(held_out, trained[j]) : held_out;
  }

  JointVerdict verdict_of(int j) const {
    if (x_.silent.count(j) != 0) return no_torque_verdict({j});
    JointVerdict v;
    v.joint = JointIndex{j};
    v.held_out = held_out_error(d_.baseline, j);
    if (!std::isfinite(v.held_out)) return not_judged({j}, v.held_out, d_.baseline);
    v.extended = held_out_error(d_.extended, j);
    v.left = v.extended;
    bool named = false, unnamed = false;
    for (const std::vector<size_t>& finding : of_finding_) {
      for (const size_t k : finding) {
        const Chosen& c = found_.chosen[k];
        const bool acts = std::find(c.columns.joints.begin(), c.columns.joints.end(), j) != c.columns.joints.end();
        const bool helps = c.of_joint.size() > j && c.of_joint[j] > 0.0;
        (c.term.kind == TermKind::kCurve ? unnamed : named) |= acts && (helps || c.term.joint);
      }
    }
    if (unnamed && left_.size() > j) v.left = std::min(v.left, v.extended * left_[j] / std::max(d_.extended.test_error.relative[j], numerics::kTiny));
    const bool repeats = d_.baseline.noise_floor.size() > j;
    v.source = repeats ? FloorSource::kRepeats : FloorSource::kRegression;
    const double other = std::min(v.left, v.held_out);
    v.floor = repeats ? std::min(d_.baseline.noise_floor[j], other) : other;
    const auto& known = x_.arm.description().identified;
    if (d_.changes && known && known->error.size() > j) v.floor = std::max(v.floor, std::min(other, known->error[j]));
    // A vibration is no floor, nor is a part that signals predict but that the tested causes exclude.
    std::optional<Vibration> vibration;
    if (!x_.poses) vibration = vibration_of(d_.extended, j, x_.options.thresholds);
    const double untested_share = found_.untested_share.size() > j ? found_.untested_share[j] : -1.0;
    const double predicted = std::max(vibration && !unnamed ? vibration->share : 0.0, untested_share);
    if (predicted > 0.0 && v.left * std::sqrt(1.0 - predicted) < v.floor) {
      v.floor = v.left * std::sqrt(1.0 - predicted);
      v.source = FloorSource::kRegression;
    }
    // An error that the training recordings do not have is no floor of the held-out ones.
    const VectorXd& trained = d_.extended.train_error.relative;
    const bool differs = trained.size() > j && v.floor > kDiffers * trained[j];
    if (differs) v.floor = trained[j];
    const bool is_unlike = trained.size() > j && other > kDiffers * std::max(trained[j], v.floor);
    v.removable = v.held_out - v.floor;
    const bool at_floor = v.left <= kAtFloor * v.floor;
    const bool mostly = v.held_out - v.extended > 0.5 * v.removable;
    if (named && v.extended < v.held_out && (mostly || (at_floor && !unnamed))) v.state = JointState::kNamed;
    else if (unnamed) v.state = JointState::kUnnamed;
    else if (named) v.state = JointState::kNamed;
    else if (least_error(j) <= kAtFloor * v.floor && untested_share < 0.0 && !is_unlike) v.state = JointState::kAtFloor;
    else if (at_floor && !of_finding_.empty()) v.state = JointState::kNamed;  // causes on other joints biased its parameters
    else {
      v.state = JointState::kCannotTell;
      const std::vector<std::string>& still = d_.baseline.still_in_test;
      if (std::find(still.begin(), still.end(), x_.arm.coordinates()[j].name) != still.end()) v.why = "it hardly moves in the held-out recordings, whose error says nothing about its motion";
      else if (vibration) v.why = vibration_words(*vibration, j);
      else if (differs || is_unlike)
        v.why = fmt::format("the training recordings leave {:.3g} % of its torque, the held-out ones {:.3g} %: something is different in them",
                            numerics::kPercent * trained[j], numerics::kPercent * v.extended);
      else v.why = torque_step_words(j) + reason_without_name(j, untested_share, repeats);
    }
    return v;
  }

  std::string vibration_words(const Vibration& vibration, int j) const {
    return fmt::format("{:.0f} % of what is left over is a vibration of {:.3g} Hz and {:.3g} {} that the motion does not have: something shakes the arm, or a part of it swings",
                       numerics::kPercent * vibration.share, vibration.frequency, vibration.amplitude, effort_unit(x_.arm.coordinates()[j]));
  }

  // Sentence about the coarse steps of a recorded torque, which no model predicts.
  std::string torque_step_words(int j) const {
    for (const RecordingQuality& q : d_.data_quality) {
      const QualityFinding* steps = q.find(QualityKind::kTorqueQuantised, JointIndex{j});
      if (steps == nullptr) continue;
      return fmt::format("its torque is recorded in steps of {:.3g} {}; ", steps->value, steps->signal == "tau" ? effort_unit(x_.arm.coordinates()[j]) : steps->unit);
    }
    return "";
  }

  std::string reason_without_name(int j, double untested_share, bool repeats) const {
    if (untested_share >= 0.0)
      return fmt::format("not all causes were asked about; signals of the motion predict {:.0f} % of what is left over", numerics::kPercent * untested_share);
    double low = numerics::kHuge, high = -numerics::kHuge;
    for (const Stretch& stretch : found_.rows->stretches()) {
      low = std::min(low, stretch.segment.q.col(j).minCoeff());
      high = std::max(high, stretch.segment.q.col(j).maxCoeff());
    }
    if (high - low <= (x_.arm.coordinates()[j].prismatic ? kStillLength : kStill)) return "it stands still in the training recordings, which say nothing about its friction";
    if (!repeats) return "what the findings leave over is no function of one or two signals of the recordings";
    std::vector<std::pair<double, std::string>> left;
    for (const auto* list : {&d_.extended.train, &d_.extended.test}) {
      for (const RecordingError& r : *list) {
        if (r.error.relative.size() > j) left.emplace_back(r.error.relative[j], r.source);
      }
    }
    const auto [least, most] = std::minmax_element(left.begin(), left.end());
    if (!left.empty() && least->first <= kAtFloor * d_.baseline.noise_floor[j] && most->first > kDiffers * least->first)
      return fmt::format("{:.2g} % of its torque are left over in {}, {:.2g} % in {}: something is different in that recording, or at one time of it",
                         numerics::kPercent * most->first, most->second, numerics::kPercent * least->first, least->second);
    if (!differing_recordings(*d_.baseline.model, d_.baseline).empty()) return "the training recordings differ from each other, and no one arm fits all of them";
    return "it comes back with the motion, yet no signal of the recordings predicts it on rows that were held out";
  }

  DiagnosisState& x_;
  Diagnosis& d_;
  int n_;
  SearchResult found_;
  std::vector<std::vector<size_t>> of_finding_;  // indices of the terms of every finding
  std::vector<int> count_;
  VectorXd left_;
};

}  // namespace

void explain(DiagnosisState& x) {
  Explanation(x).write();
}

}  // namespace veridyn::search
