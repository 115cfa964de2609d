#include "veridyn/identification/robot_check.hpp"
#include "veridyn/identification/verdict.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "identification/check/answers.hpp"
#include "identification/check/check_thresholds.hpp"
#include "identification/check/quick_fit.hpp"
#include "identification/check/questions.hpp"
#include "identification/identification_numbers.hpp"
#include "model/correlated_joints.hpp"
#include "math/median.hpp"
#include "math/numbers.hpp"
#include "math/parallel.hpp"
#include "recordings/kept_recordings.hpp"
#include "recordings/recorded_motion.hpp"
#include "recordings/quality/quality_checks.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

std::string percent_text(double share) {
  return text(quality::number(100.0 * share), " %");
}

std::string uncapitalised(std::string sentence) {
  sentence.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(sentence.front())));
  return sentence;
}

// A set of accepted hypotheses with the fit after their corrections.
struct Answer {
  std::vector<RecordingQuestion> set;
  QuickFit fit;
  double score = 0.0;  // misfit and costs, relative to the recording without corrections
  MatrixXd before;     // shares in the folds without the last hypothesis
  double fitted_gain = 0.0;  // decrease of the misfit of the fit to all rows by the last hypothesis
};

class RobotCheck {
 public:
  RobotCheck(const Model& arm, Recording recording, const PreprocessingOptions& options)
      : given_(arm), options_(options), recording_(std::move(recording)), facts_(facts_of(recording_, options)), fitter_(arm, options, facts_) {
    moves_ = quality::Head(recording_).moves;
  }

  // Delays and gains of torques, which a diagnosis estimates itself, are neither reported nor corrected after
  // this call.
  void exclude_causes() { excludes_causes_ = true; }

  RobotAnswers run(double smallest_error = 0.0) {
    RobotAnswers out;
    if (is_identifiable()) {
      best_.fit = fit_of({});
      const QuickFit before = best_.fit;
      out.explained = is_explained(before);
      out.left = before.relative_error();
      if (!(out.left > smallest_error)) return out;  // hardly moving joints were reported for the first recording
      search();
      const Answer none{{}, before, 0.0, {}};
      if (!helps(best_, before)) best_ = none;
      if (!is_explained(best_) && std::any_of(best_.set.begin(), best_.set.end(), is_fitted)) {
        const Answer fitted = std::exchange(best_, none);
        report_uncertain(fitted, "a force on the arm or anything that it lacks looks alike, and the noise is at " + percent_text(before.noise()));
      }
      const bool whole = recording_.rows() >= checking::kRowsOfAnArm;
      if (whole && has_sizes_without_sign(before)) best_ = none;
      else if (whole) report_unexplained();
      out.mends = is_explained(best_) || best_.fit.relative_error() < checking::kClearImprovement * before.relative_error();
      const auto causes = std::remove_if(best_.set.begin(), best_.set.end(), [this](const RecordingQuestion& q) { return excludes_causes_ && q.is_cause; });
      if (causes != best_.set.end()) {
        best_.set.erase(causes, best_.set.end());
        best_.fit = fit_of(best_.set);
      }
      report(before.relative_error(), other_sound_part());
      report_values();
      report_weak_motions();
      out.set = std::move(best_.set);
    }
    const Recording corrected = corrected_recording(out.mends ? out.set : std::vector<RecordingQuestion>());
    report_hardly_moving_joints(corrected);
    report_efforts(corrected);
    report_limits(corrected);
    out.findings = std::move(findings_);
    return out;
  }

  bool would_explain(const std::vector<RecordingQuestion>& set) const {
    const QuickFit before = fit_of({});
    return !is_explained(before) && is_clear_improvement(fit_of(set), before);
  }

  bool fits_better_without(const std::vector<RecordingQuestion>& set) { return is_identifiable() && fit_of(set).misfit > fit_of({}).misfit + checking::kMisfitDecrease; }

  // True unless the remaining error is so large that the correction may only imitate a missing effect.
  static bool helps(const Answer& answer, const QuickFit& before) {
    const QuickFit& after = answer.fit;
    const bool is_sure = std::all_of(answer.set.begin(), answer.set.end(), [&](const RecordingQuestion& q) {
      return q.joint ? std::sqrt(after.shares[q.joint->value]) < checking::kSignCertain : after.relative_error() < checking::kUnexplained;
    });
    if (is_explained(answer)) return true;
    if (std::any_of(answer.set.begin(), answer.set.end(), [](const RecordingQuestion& q) { return is_fitted(q) || scales_joints_apart(q); }))
      return is_clear_improvement(after, before) && after.contradictions <= before.contradictions;  // a torque that is scaled to zero would leave no error
    return after.relative_error() < checking::kFitted * before.relative_error() || (after.contradictions < before.contradictions && is_sure);
  }

  // Reports joints that the arm explains badly and whose torque reaches zero without ever changing its sign.
  bool has_sizes_without_sign(const QuickFit& before) {
    const std::size_t known = findings_.size();
    for (int i = 0; i < joints() && !is_explained(best_); ++i) {
      const double left = std::sqrt(before.shares[i]);
      const auto tau = recording_.tau.col(i).array();
      const bool touches = tau.abs().minCoeff() < checking::kReachesZero * std::sqrt(tau.square().mean());
      if (moves(i) && left > checking::kSignCertain && touches && !((tau < 0.0).any() && (tau > 0.0).any()))
        add_finding(QualityKind::kNoSign, JointIndex{i}, left, text("The torque of ", joint_text(i), " has one sign in every row, and ", percent_text(left), " of it does not follow from the motion: a size without its sign?"));
    }
    return findings_.size() > known;
  }

  void report_unexplained() {
    report_not_this_arm();
    int worst = 0;
    const double left = std::sqrt(best_.fit.fitted.maxCoeff(&worst));
    if (!findings_.empty() || !moves(worst) || !(left > checking::kCheckAboveError)) return;
    add_finding(QualityKind::kUnexplained, JointIndex{worst}, left,
        text("With all its parameters free ", given_.name(), " leaves ", percent_text(left), " of the torque of ", joint_text(worst),
             ": it lacks something, or something is wrong with the recording; `veridyn diagnose` asks what."), Severity::kWarning);
  }

  void report_not_this_arm() {
    if (best_.fit.relative_error() > checking::kUnexplained && best_.fit.fitted_relative_error() > checking::kUnexplained) {
      add_finding(QualityKind::kUnexplained, {}, best_.fit.relative_error(),
          text("With all its parameters free ", given_.name(), " leaves ", percent_text(best_.fit.relative_error()),
               " of the torque on held-out rows, and no single mistake that `check` knows explains it: the torques of another robot, or a time or a column that does not belong to the others?"));
      return;
    }
    for (int i = 0; i < joints(); ++i) {
      const double left = std::sqrt(best_.fit.shares[i]);
      if (moves(i) && left > checking::kUnexplainedJoint && std::sqrt(best_.fit.fitted[i]) > checking::kUnexplained)
        add_finding(QualityKind::kUnexplained, JointIndex{i}, left, text("Nothing of the torque of ", joint_text(i), " follows from its motion: a joint that nothing drives, or another signal in its column?"));
    }
  }

  // True if the arm is explained after a correction, or its relative error has decreased by much.
  static bool is_clear_improvement(const QuickFit& after, const QuickFit& before) {
    return is_explained(after) || after.relative_error() < checking::kClearImprovement * before.relative_error();
  }

 private:
  // True if the base parameters are identifiable; otherwise wrong signals would fit as well as correct ones.
  bool is_identifiable() {
    if (std::none_of(moves_.begin(), moves_.end(), [](bool moves) { return moves; })) return false;
    MatrixXd moving = recording_.q;
    for (int i = 0; i < joints(); ++i) {
      if (!moves(i)) moving.col(i).setZero();
    }
    const std::vector<std::vector<JointIndex>> as_one = correlated_joints(moving);
    if (!as_one.empty()) {
      add_finding(QualityKind::kNotCompared, as_one.front().front(), 0.0, text("Signs, order and units of the joints are not compared with ", given_.name(), ": joints ", numbers_from_one(as_one.front()), " move as one."), Severity::kInfo);
      return false;
    }
    const auto [determined, all, condition] = fitter_.rank_and_condition(recording_);
    if (determined >= all && condition < checking::kWorstCondition) return true;
    // Wrong units change the columns and their condition number, so that units are tested before the check is
    // given up.
    if (determined >= all && find_unit()) return true;
    add_finding(QualityKind::kNotCompared, {}, determined,
        text("Signs, order and units of the joints are not compared with ", given_.name(),
             ": the recording ", determined < all ? "determines " : "hardly tells apart ",
             determined, " of its ", all, " base parameters.",
             recording_.current.size() > 0 && std::none_of(given_.coordinates().begin(), given_.coordinates().end(), [](const Coordinate& c) { return c.drive_gain > 0.0; })
                 ? " It holds currents, and the robot file no drive gains: --drive-gains gives them, `identify --known-mass` finds them." : ""), Severity::kInfo);
    return false;
  }

  // True if another unit of all joints explains the torques.
  bool find_unit() {
    Answer as_recorded;
    as_recorded.fit = fit_of({});
    std::vector<RecordingQuestion> units = open_questions(as_recorded);
    units.erase(std::remove_if(units.begin(), units.end(), [](const RecordingQuestion& q) { return q.joint || q.units.empty(); }), units.end());
    const std::vector<Answer> all = evaluate_hypotheses(as_recorded, units);
    return std::any_of(all.begin(), all.end(), [&](const Answer& one) { return is_explained(one.fit) && !is_explained(as_recorded.fit); });
  }

  double travel(int i, const Recording& recording) const { return quality::between_quantiles({recording.q.col(i).begin(), recording.q.col(i).end()}, 0.0, 1.0); }

  void report_hardly_moving_joints(const Recording& recording) {
    for (int i = 0; i < joints() && recording.rows() > 0; ++i) {
      const Limits& limits = given_.coordinates()[i].limits;
      const double share = travel(i, recording) / (limits.upper - limits.lower);
      if (!moves(i) || !std::isfinite(limits.upper - limits.lower) || !(share < kHardlyMovingShare)) continue;
      add_finding(QualityKind::kHardlyMoves, JointIndex{i}, share,
          text("In its first ", quality::number(recording.time[recording.rows() - 1] - recording.time[0]), " s ", joint_text(i),
               " moves over ", percent_text(share), " of its range: little of its friction and inertia can be identified."), Severity::kWarning);
    }
  }

  // Reports joints that move too little: over a small range gravity is nearly linear, as a spring is.
  void report_weak_motions() {
    const VectorXd apart = fitter_.independent_spring_shares(corrected_recording(best_.set));
    for (int i = 0; i < joints(); ++i) {
      const Coordinate& c = given_.coordinates()[i];
      if (!moves(i) || c.prismatic || !(apart[i] < checking::kSpringApart) || travel(i, recording_) > checking::kWeakly * (c.limits.upper - c.limits.lower)) continue;
      add_finding(QualityKind::kWeakMotion, JointIndex{i}, apart[i],
          text("The motion of ", joint_text(i), " is too small for its torque at other angles: a spring and a load cannot be told apart (",
               percent_text(1.0 - apart[i]), " of a spring's torque could be gravity's)."), Severity::kWarning);
    }
  }

  int joints() const { return given_.joints(); }
  bool moves(int i) const { return moves_[static_cast<size_t>(i)]; }
  std::string joint_text(int i) const { return text("joint ", i + 1, " (", given_.coordinates()[static_cast<size_t>(i)].name, ")"); }

  void add_finding(QualityKind kind, std::optional<JointIndex> joint, double value, const std::string& sentence, Severity severity = Severity::kFault) {
    QualityFinding f;
    f.file = recording_.source;
    f.kind = kind;
    f.joint = joint;
    f.share = quality::kNone;
    f.value = value;
    f.severity = severity;
    f.sentence = sentence;
    findings_.push_back(std::move(f));
  }

  static bool is_of_torques(QualityKind kind) {
    return kind == QualityKind::kTorqueSign || kind == QualityKind::kTorqueUnit || kind == QualityKind::kTorqueClock || kind == QualityKind::kTorqueDelay || kind == QualityKind::kTorqueFilter;
  }

  static bool is_explained(const QuickFit& fit) { return fit.is_near() && fit.contradictions == 0.0; }

  // True for corrections that can absorb errors of the model: a fitted direction of gravity absorbs a part of
  // any external force; a delay, or excluded rows, a part of any missing effect.
  static bool is_fitted(const RecordingQuestion& q) { return (q.robot || q.rows) && q.neighbours; }
  // True for different factors on single torques, which can imitate many missing effects.
  static bool scales_joints_apart(const RecordingQuestion& q) {
    return q.kind == QualityKind::kTorqueUnit && (q.joint || q.price > 0.0 || q.units == "tau=%" || q.units == "tau=permille" || q.units == "tau=share");
  }
  static bool is_explained(const Answer& answer) {
    const bool fitted = std::any_of(answer.set.begin(), answer.set.end(), is_fitted);
    return is_explained(answer.fit) && (!fitted || answer.fit.relative_error() <= std::max(checking::kNearNoise * answer.fit.noise(), checking::kFittedNear));
  }

  Recording corrected_recording(const std::vector<RecordingQuestion>& set) const {
    Recording out = recording_;
    apply_to(set, given_, out);
    return out;
  }

  // The linear map from the recorded torques to the corrected ones, with the units and exchanges of a set.
  MatrixXd torques_of(std::vector<RecordingQuestion> set) const {
    set.erase(std::remove_if(set.begin(), set.end(), corrects_rows), set.end());
    Recording units;
    units.tau = MatrixXd::Identity(joints(), joints());
    apply_to(set, given_, units);
    return units.tau;
  }

  static bool corrects_rows(const RecordingQuestion& q) { return q.rows || q.units == "tau=load"; }

  // Fit to the recording with these corrections.
  QuickFit fit_of(std::vector<RecordingQuestion> set, VelocitySource velocity = VelocitySource::kRecorded) const {
    const auto others = std::stable_partition(set.begin(), set.end(), corrects_rows);
    Recording recording = corrected_recording({others, set.end()});
    recording.tau = recording_.tau;
    apply_to({set.begin(), others}, given_, recording);
    if (velocity == VelocitySource::kRecorded && !any_changes_robot(set)) return fitter_.fit(fitter_.moments(recording), torques_of(set));
    PreprocessingOptions how = options_;
    if (velocity == VelocitySource::kDerived) how.velocity = velocity;
    const QuickFitter fitter(corrected_arm(set, given_), how, facts_);
    return fitter.fit(fitter.moments(recording), torques_of(set));
  }

  // Tries one more hypothesis of the list. Transformations that leave the motion unchanged reuse its regressor.
  std::vector<Answer> evaluate_hypotheses(const Answer& before, const std::vector<RecordingQuestion>& questions) const {
    std::vector<Answer> out(questions.size());
    const bool same_arm = !any_changes_robot(before.set);
    parallel_for(static_cast<int>(questions.size()), 0, [&](int k) {
      Answer& one = out[k];
      one.set = before.set;
      one.set.push_back(questions[k]);
      one.fit = same_arm && questions[k].maps_torques() ? fitter_.fit(before.fit.moments, torques_of(one.set)) : fit_of(one.set);
      one.fitted_gain = before.fit.fitted_misfit - one.fit.fitted_misfit;
      // A hypothesis that excludes rows is compared on the remaining rows, since the excluded ones bias a fit
      // to all rows.
      if (questions[k].kind == QualityKind::kChangedMidway && one.fit.moments != nullptr && before.fit.values.size() > 0)
        one.fitted_gain = fitter_.misfit_of(before.fit.values, *one.fit.moments, torques_of(one.set)) + one.fit.contradictions - one.fit.fitted_misfit;
      if (!(one.fit.misfit < before.fit.misfit)) one.fit.moments.reset();
    });
    return out;
  }

  // Hypotheses that remain after those accepted so far. If only the file's values or the sign of friction
  // contradict, they concern torques and gravity.
  std::vector<RecordingQuestion> open_questions(const Answer& so_far) const {
    std::vector<RecordingQuestion> all = questions_of(given_, recording_, options_.signals, moves_, so_far.fit);
    const bool fits = so_far.fit.is_near();
    const auto closed = [&](const RecordingQuestion& q) {
      if (fits && q.kind != QualityKind::kGravity && q.kind != QualityKind::kCurrent && !is_of_torques(q.kind)) return true;
      return std::any_of(so_far.set.begin(), so_far.set.end(), [&](const RecordingQuestion& chosen) {
        return chosen.excludes(q) || (chosen.kind == q.kind && chosen.joint == q.joint && chosen.second == q.second);
      });
    };
    all.erase(std::remove_if(all.begin(), all.end(), closed), all.end());
    return all;
  }

  // Beam search: each of the best few sets is extended by every remaining hypothesis that improves the fit clearly.
  void search() {
    std::vector<Answer> beam = {best_};
    std::optional<std::pair<Answer, const char*>> doubt;  // an uncertain set; a further mistake may still make it certain
    for (int level = 0; level < checking::kMostTogether && !beam.empty() && !is_explained(best_); ++level) {
      std::vector<Answer> next, impossible;
      for (const Answer& parent : beam) {
        for (Answer& one : evaluate_hypotheses(parent, open_questions(parent))) {
          const RecordingQuestion& q = one.set.back();
          const double needed = q.kind == QualityKind::kCurrent ? checking::kGainsBetter : checking::kMisfitDecrease;
          one.score = parent.score + one.fit.misfit - parent.fit.misfit + needed + q.price;
          // The file's values are those of its own convention, so that they cannot contradict the other one.
          if (q.kind == QualityKind::kDhConvention) one.score += parent.fit.contradictions - one.fit.contradictions;
          one.before = parent.fit.folds;
          // Rows that differ from all others have a large held-out error without any mistake. The correction of
          // a mistake, in contrast, also lowers the error of a fit to all rows.
          if (one.score < parent.score && one.fitted_gain > needed) (is_possible(one) ? next : impossible).push_back(std::move(one));
        }
      }
      const auto better = [](const Answer& a, const Answer& b) { return std::pair(!is_explained(a), a.score) < std::pair(!is_explained(b), b.score); };
      std::sort(next.begin(), next.end(), better);
      std::sort(impossible.begin(), impossible.end(), better);
      if (best_.set.empty() && !impossible.empty() && (next.empty() || (is_explained(impossible.front()) && !is_explained(next.front())))) {
        report_uncertain(impossible.front(), beyond_efforts(corrected_recording(impossible.front().set)) > beyond_efforts(recording_)
                                                 ? "such torques are beyond the efforts of the robot file: are its masses in another unit, as grams?"
                                                 : "as recorded, all positions lie within the limits of the joints");
        return;
      }
      const auto concerns_velocity = [](const Answer& one) { return one.set.back().units.rfind("dq=", 0) == 0; };
      if (level == 0 && recording_.dq.size() > 0 && (next.empty() || !is_explained(next.front()))) {
        QuickFit derived = fit_of({}, VelocitySource::kDerived);
        if (is_explained(derived)) {  // the check of velocities reports them
          best_.fit = std::move(derived);
          return;
        }
      }
      const std::vector<Answer> all = next;
      keep_best_start_values(next);
      for (Answer& one : next) one = polished(one);
      // A fitted number, or another arm, reduces the error of any incomplete model a little.
      next.erase(std::remove_if(next.begin(), next.end(), [&](const Answer& one) {
                   return (one.set.back().neighbours || one.set.back().robot) && !is_explained(one) && one.fit.relative_error() > checking::kFitted * best_.fit.relative_error();
                 }), next.end());
      if (next.empty()) break;
      std::sort(next.begin(), next.end(), better);
      // Friction near rest is uncertain where the recorded velocity is noisy.
      if (!is_explained(next.front()) && !concerns_velocity(next.front())) {
        QuickFit quieter = fit_of(next.front().set, VelocitySource::kDerived);
        if (is_explained(quieter)) next.front().fit = std::move(quieter);
      }
      if (is_explained(next.front())) {
        best_ = next.front();
        return;
      }
      if (doubt) break;
      if (const char* but = reason_for_uncertainty(next.front(), all)) doubt = std::make_pair(next.front(), but);
      else if (next.front().score < best_.score) best_ = next.front();
      beam = std::move(next);
    }
    if (doubt && doubt->first.fit.relative_error() < checking::kFitted * best_.fit.relative_error()) report_uncertain(doubt->first, doubt->second);
  }

  // Keeps one starting value for each fitted number.
  static void keep_best_start_values(std::vector<Answer>& sorted) {
    std::vector<Answer> kept;
    for (Answer& one : sorted) {
      const bool again = one.set.back().neighbours && std::any_of(kept.begin(), kept.end(), [&](const Answer& other) {
                           return other.set.size() == one.set.size() && other.set.back().kind == one.set.back().kind && other.set.back().joint == one.set.back().joint &&
                                  std::equal(other.set.begin(), other.set.end() - 1, one.set.begin(), [](const RecordingQuestion& a, const RecordingQuestion& b) { return a.what == b.what; });
                         });
      if (!again && static_cast<int>(kept.size()) < checking::kBeam) kept.push_back(std::move(one));
    }
    sorted = std::move(kept);
  }

  // Reason for which a set is uncertain, or null: exclusive sets have nearly the same score, as they do where
  // joints move alike and the arm does not explain a torque; or a set helps in a part of the recording only.
  static const char* reason_for_uncertainty(const Answer& answer, const std::vector<Answer>& others) {
    const RecordingQuestion& q = answer.set.back();
    if (is_explained(answer) || q.kind == QualityKind::kTorqueSign || q.neighbours) return nullptr;
    for (const Answer& other : others) {
      const RecordingQuestion& rival = other.set.back();
      const bool same = rival.what == q.what || other.set.size() != answer.set.size();
      if (!same && q.excludes(rival) && other.score < answer.score + checking::kMisfitDecrease)
        return "another exchange does nearly as well, so that none of them is sure";
    }
    for (const std::optional<JointIndex> k : {q.joint, q.second}) {
      if (k && (answer.fit.folds.row(k->value).array() > answer.before.row(k->value).array()).any())
        return "a joint that it concerns is explained no better in a part of the recording";
    }
    return nullptr;
  }

  // Refines the fitted number of the last hypothesis, with steps that are halved.
  Answer polished(Answer answer) const {
    if (answer.set.back().kind == QualityKind::kEncoderZero && is_explained(answer)) return answer;  // an exact multiple of a quarter turn
    const double first = answer.set.back().first_distance;
    for (double step = 0.5 * first; answer.set.back().neighbours && step > checking::kFinest * first;) {
      Answer without = answer;
      without.set.pop_back();
      std::vector<Answer> all = evaluate_hypotheses(without, answer.set.back().neighbours(step));
      const auto least = std::min_element(all.begin(), all.end(), [](const Answer& a, const Answer& b) { return a.fit.misfit < b.fit.misfit; });
      if (least->fit.misfit < answer.fit.misfit) {
        answer.score += least->fit.misfit - answer.fit.misfit;
        answer.set = least->set;
        answer.fit = least->fit;
      } else {
        step *= 0.5;
      }
    }
    return answer;
  }

  // Number of joints whose positions lie outside of their limits.
  int beyond_limits(const Recording& recording) const {
    int out = 0;
    for (int i = 0; i < joints(); ++i) out += leaves_limits(given_, {i}, recording) ? 1 : 0;
    return out;
  }

  // Largest torque of a joint relative to its largest effort.
  double share_of_effort(int i, const Recording& recording) const {
    const double effort = given_.coordinates()[static_cast<size_t>(i)].limits.effort;
    return recording.tau.cols() > 0 && effort > 0.0 ? recording.tau.col(i).cwiseAbs().maxCoeff<Eigen::PropagateNumbers>() / effort : 0.0;
  }

  // Number of joints whose torques are several times their largest effort.
  int beyond_efforts(const Recording& recording) const {
    int out = 0;
    for (int i = 0; i < joints(); ++i) out += share_of_effort(i, recording) > checking::kBeyondEffort ? 1 : 0;
    return out;
  }

  void report_efforts(const Recording& recording) {
    double most = 0.0;
    std::string names;
    std::optional<JointIndex> first;
    int count = 0;
    for (int i = 0; i < joints(); ++i) {
      const double share = share_of_effort(i, recording);
      if (!(share > checking::kBeyondEffort)) continue;
      if (++count == 1) first = JointIndex{i};
      most = std::max(most, share);
      names += (names.empty() ? "" : ", ") + joint_text(i);
    }
    if (count > 0)
      add_finding(QualityKind::kBeyondEffort, count == 1 ? first : std::nullopt, most,
          text("The torque of ", names, " reaches ", quality::number(most), " times the effort of the robot file: another unit, another drive gain, or a wrong effort?"));
  }

  // Reports joints outside of their limits, or faster than these, by as much as no joint with such limits moves.
  void report_limits(const Recording& recording) {
    for (int i = 0; i < joints(); ++i) {
      const Limits& limits = given_.coordinates()[static_cast<size_t>(i)].limits;
      const double furthest = recording.q.col(i).cwiseAbs().maxCoeff<Eigen::PropagateNumbers>();
      if (moves(i) && leaves_limits(given_, JointIndex{i}, recording))
        add_finding(QualityKind::kBeyondLimits, JointIndex{i}, furthest, text("The position of ", joint_text(i), " reaches ", quality::number(furthest), ", and the limits of the robot file are ", quality::number(limits.lower), " to ", quality::number(limits.upper),
                                                           ": another unit, another zero, or wrong limits?"), Severity::kWarning);
      const double speed = recording.dq.size() > 0 ? recording.dq.col(i).cwiseAbs().maxCoeff<Eigen::PropagateNumbers>() : 0.0;
      if (limits.velocity > 0.0 && speed > checking::kBeyondEffort * limits.velocity)
        add_finding(QualityKind::kBeyondSpeed, JointIndex{i}, speed, text("The speed of ", joint_text(i), " reaches ", quality::number(speed / limits.velocity), " times the limit of the robot file: another unit, or a wrong limit?"), Severity::kWarning);
    }
  }

  // True if the corrected positions are within the limits, or outside no more than those recorded, and torques within the
  // efforts. A change of units also needs positions that cannot be radians.
  bool is_possible(const Answer& answer) const {
    const RecordingQuestion& q = answer.set.back();
    if (q.kind == QualityKind::kTorqueUnit && beyond_efforts(corrected_recording(answer.set)) > beyond_efforts(recording_)) return false;
    const int as_recorded = beyond_limits(recording_);
    const auto limited = [](const Coordinate& c) { return !c.prismatic && std::isfinite(c.limits.upper - c.limits.lower); };
    if (q.units.rfind("q=", 0) == 0 && q.kind != QualityKind::kTurns && q.kind != QualityKind::kGivenUnit)
      return as_recorded > 0 || std::none_of(given_.coordinates().begin(), given_.coordinates().end(), limited);
    return beyond_limits(corrected_recording(answer.set)) <= as_recorded;
  }

  void report_uncertain(const Answer& answer, const std::string& but) {
    const RecordingQuestion& q = answer.set.back();
    if (recording_.rows() < checking::kRowsOfAnArm) return;
    add_finding(q.kind, q.joint, answer.fit.relative_error(), text("Perhaps ", uncapitalised(q.what), ": ", reason_for(q, answer.fit.relative_error(), best_.fit.relative_error()), ", but ", but, std::string(but).back() == '?' ? "" : "."),
        Severity::kInfo);
  }

  static std::string reason_for(const RecordingQuestion& q, double left, double without) {
    if (left < checking::kFitCounts * without) return text("so the arm leaves ", percent_text(left), " of the torque on held-out rows instead of ", percent_text(without));
    return q.kind == QualityKind::kTorqueSign ? "so say its friction and the values of the robot file" : "so say the values of the robot file";
  }

  // Relative error (n) of the torques that were not excluded with the values of the robot, divided by that with free ones; empty
  // unless all values are known, those of friction included.
  VectorXd values_against_free(const Answer& answer) const {
    if (given_.description().values != RobotValues::kFacts || given_.effects().empty() || !has_all_values(given_)) return {};
    IdentificationOptions how;
    how.preprocessing = options_;
    how.preprocessing.kept.reset();  // those of the name, not of these rows
    const Recording corrected = corrected_recording(answer.set);
    int first = 0, end = corrected.rows();
    while (first < end && !corrected.tau.row(first).array().isFinite().any()) ++first;
    while (first < end && !corrected.tau.row(end - 1).array().isFinite().any()) --end;
    try {
      VectorXd out = evaluate(corrected_arm(answer.set, given_), rows_of(corrected, first, end - first), {}, how).train_error.relative;
      for (int i = 0; i < out.size(); ++i) out[i] = moves(i) ? out[i] / free_error(answer, i) : 0.0;
      return out;
    } catch (const InvalidInput&) {
      return {};  // too few rows are left
    }
  }

  static double free_error(const Answer& answer, int joint) { return std::max(std::sqrt(answer.fit.shares[joint]), checking::kExact); }

  bool is_explained_by_values(const Answer& answer) const {
    const VectorXd ratios = values_against_free(answer);
    return ratios.size() > 0 && ratios.maxCoeff() <= identifying::numbers.outstanding;
  }

  // If something changes within the recording, keeps the part that the known values explain. Returns the option for the other
  // part if it fits as well and nothing tells which one is sound.
  std::string other_sound_part() {
    const auto cut = std::find_if(best_.set.begin(), best_.set.end(), [](const RecordingQuestion& q) { return q.kind == QualityKind::kChangedMidway; });
    if (cut == best_.set.end()) return "";
    const double step = (recording_.time[recording_.rows() - 1] - recording_.time[0]) / checking::kMoments;
    Answer rest;  // the part on the other side of the change that fits best
    std::vector<RecordingQuestion> other;
    for (int k = 0; !(other = cut->neighbours(k * step)).empty(); ++k) {
      Answer one = best_;
      one.set[static_cast<std::size_t>(cut - best_.set.begin())] = other.front();
      one.fit = fit_of(one.set);
      if (rest.set.empty() || one.fit.fitted_relative_error() < rest.fit.fitted_relative_error()) rest = std::move(one);
    }
    if (rest.set.empty() || rest.fit.fitted_relative_error() > identifying::numbers.outstanding * best_.fit.fitted_relative_error()) return "";
    const std::string option = rest.set[static_cast<std::size_t>(cut - best_.set.begin())].other;
    const bool here = is_explained_by_values(best_), there = is_explained_by_values(rest);
    if (there && !here) best_ = std::move(rest);
    return here != there ? "" : option;
  }

  // Reports the joint whose torque the known values of the robot explain far worse than free ones, if nothing else is wrong.
  void report_values() {
    if (!findings_.empty()) return;
    const VectorXd ratios = values_against_free(best_);
    int worst = 0;
    if (ratios.size() == 0 || !(ratios.maxCoeff(&worst) > identifying::numbers.outstanding)) return;
    const double left = ratios[worst] * free_error(best_, worst);
    add_finding(QualityKind::kValues, JointIndex{worst}, left,
        text("The values of ", given_.name(), " leave ", percent_text(left), " of the torque of ", joint_text(worst), ", free parameters ", percent_text(std::sqrt(best_.fit.shares[worst])),
             ": another load, friction, zero or mount than the robot file has? `veridyn diagnose` asks what changed."), Severity::kWarning);
  }

  // Reports one line for each accepted hypothesis, with the error without it and all options together.
  // @param also  option that does as well as that of a change within the recording; empty: none.
  void report(double before, const std::string& also) {
    std::sort(best_.set.begin(), best_.set.end(), [](const RecordingQuestion& a, const RecordingQuestion& b) { return std::tie(a.kind, a.joint) < std::tie(b.kind, b.joint); });
    const std::string given = given_options(options_.signals), options = options_of(best_.set, options_.signals, given_);
    for (const RecordingQuestion& q : best_.set) {
      std::vector<RecordingQuestion> others = best_.set;
      others.erase(others.begin() + (&q - best_.set.data()));
      const double without = others.empty() ? before : fit_of(others).relative_error();
      const double left = best_.fit.relative_error();
      const bool read_with_options = !given.empty() && q.changes_recording() && !q.rows;
      std::string sentence = (read_with_options ? "Read with " + given + ", " + uncapitalised(q.what) : q.what) + ": " + reason_for(q, left, without) + "; ";
      if (is_explained(best_)) sentence += options + (also.empty() ? " mends it." : " mends it, and so does " + also + "; these rows do not tell which part is sound.");
      else sentence += text(options, " makes it better, but the noise is at ", percent_text(best_.fit.noise()), ": not the whole truth.");
      add_finding(q.kind, q.joint, left, sentence);
    }
  }

  const Model& given_;
  PreprocessingOptions options_;
  Recording recording_;
  RecordedFacts facts_;
  QuickFitter fitter_;
  std::vector<bool> moves_;  // joints that can be checked
  bool excludes_causes_ = false;
  Answer best_;
  std::vector<QualityFinding> findings_;
};

PreprocessingOptions whole(PreprocessingOptions options) {
  options.first_row = 0;
  options.row_count.reset();
  return options;
}

// The check of a recording; nullopt if it has too little data.
std::optional<RobotCheck> check_of(const Model& arm, Recording recording, const PreprocessingOptions& options) {
  require_joints_of(arm, recording.joints(), recording.source);
  const long first = std::min<long>(options.first_row, recording.rows());
  const long wanted = std::min<long>(options.row_count.value_or(checking::kMostRows), checking::kMostRows);
  const long count = std::min(wanted, recording.rows() - first);
  if (first > 0 || count < recording.rows())
    recording = rows_of(recording, static_cast<int>(first), static_cast<int>(count));
  if (recording.rows() < checking::kFewestRows) return {};
  if (options.cutoff > 0.0 && median_step(recording.time) * options.cutoff >= 0.5) return {};  // the filter needs two rows per period
  set_torques_from_currents(arm, recording);
  if (recording.tau.size() == 0) return {};
  if (recording.dq.isZero(0.0)) recording.dq.resize(0, 0);
  for (int i = 0; i < arm.joints(); ++i) {
    if (recording.tau.col(i).array().isNaN().all() || recording.q.col(i).array().isNaN().all()) return {};  // the check of gaps names it
  }
  return std::optional<RobotCheck>(std::in_place, arm, std::move(recording), whole(options));
}

std::optional<RobotCheck> check_of(const Model& arm, const std::string& name, const PreprocessingOptions& options) {
  if (const Recording* there = find_in_memory(options.in_memory, name)) return check_of(arm, *there, options);
  RecordingOptions reading = recording_options_for(arm, options);
  reading.first_row = std::max(0L, options.first_row);
  reading.row_count = std::min<long>(options.row_count.value_or(checking::kMostRows), checking::kMostRows);
  Recording recording = read_rows(name, reading, options.kept.get());
  recording.source = name;
  return check_of(arm, std::move(recording), whole(options));
}

}  // namespace

void set_torques_from_currents(const Model& arm, Recording& recording) {
  if (recording.tau.size() > 0 || recording.current.size() == 0) return;
  recording.tau = recording.current;
  for (int i = 0; i < arm.joints(); ++i) {
    if (arm.coordinates()[i].drive_gain > 0.0) recording.tau.col(i) *= arm.coordinates()[i].drive_gain;
  }
}

RobotAnswers answers_of(const Model& arm, const std::string& recording, const PreprocessingOptions& options, double smallest_error) {
  std::optional<RobotCheck> check = check_of(arm, recording, options);
  if (!check) return {};
  check->exclude_causes();
  return check->run(smallest_error);
}

bool would_explain(const std::vector<RecordingQuestion>& set, const Model& arm, const std::string& recording, const PreprocessingOptions& options) {
  const std::optional<RobotCheck> check = check_of(arm, recording, options);
  return check && check->would_explain(set);
}

bool fits_better_without(const std::vector<RecordingQuestion>& set, const Model& arm, const std::string& recording, const PreprocessingOptions& options) {
  std::optional<RobotCheck> check = check_of(arm, recording, options);
  return check && check->fits_better_without(set);
}

std::vector<QualityFinding> check_against(const Model& arm, const std::string& path, const PreprocessingOptions& options) {
  std::optional<RobotCheck> check = check_of(arm, path, options);
  return check ? check->run().findings : std::vector<QualityFinding>();
}

std::vector<QualityFinding> check_against(const Model& arm, Recording recording, const PreprocessingOptions& options) {
  std::optional<RobotCheck> check = check_of(arm, std::move(recording), options);
  return check ? check->run().findings : std::vector<QualityFinding>();
}

}  // namespace veridyn
