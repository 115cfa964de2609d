#include "identification/check/answers.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "identification/check/check_thresholds.hpp"
#include "identification/identification_numbers.hpp"
#include "recordings/kept_recordings.hpp"
#include "veridyn/identification/robot_check.hpp"

// Combines the contradictions found in all recordings of a command, and applies the transformations that
// remove them.

namespace veridyn {
namespace {

// Removes repeated findings. If recordings disagree about a joint, the most frequent finding remains.
std::vector<QualityFinding> once_each(const std::vector<QualityFinding>& all) {
  using Key = std::pair<QualityKind, std::optional<JointIndex>>;
  std::map<Key, int> votes;
  for (const QualityFinding& f : all) ++votes[{f.kind, f.joint}];
  std::vector<QualityFinding> out;
  std::set<Key> said;
  for (const QualityFinding& f : all) {
    const int own = votes.at({f.kind, f.joint});
    const bool outvoted = std::any_of(votes.begin(), votes.end(), [&](const auto& other) { return other.first.second == f.joint && other.second > own; });
    if (!outvoted && said.insert({f.kind, f.joint}).second) out.push_back(f);
  }
  return out;
}

// True for a contradiction that a diagnosis estimates as a cause or reports itself: a change during the
// recording, such as a push, and a tilted base (against an identified model any direction of gravity).
bool is_left_to_a_diagnosis(const RecordingQuestion& q, const Model& arm) {
  if (q.kind == QualityKind::kChangedMidway) return true;
  if (q.kind != QualityKind::kGravity) return false;
  if (arm.description().values == RobotValues::kFacts && has_all_values(arm)) return true;
  const Eigen::Vector3d turned = corrected_arm({q}, arm).gravity();
  return turned.dot(arm.gravity()) > checking::kLeaning * turned.norm() * arm.gravity().norm() && !turned.isZero();
}

class SetUp {
 public:
  SetUp(const Model& arm, const PreprocessingOptions& options) : options_(options) { out_.arm = arm; }

  void learn_from(const std::string& name) {
    if (has_first_mistakes(name)) return;
    examine(name);
    Examined& one = examined_.back();
    std::vector<RecordingQuestion>& set = one.answers.set;
    set.erase(std::remove_if(set.begin(), set.end(), [this](const RecordingQuestion& q) { return is_left_to_a_diagnosis(q, out_.arm); }), set.end());
    if (!one.answers.mends) return;
    one.applied = set;
    if (any_changes_robot(set)) out_.arm = corrected_arm(set, out_.arm);
    if (first_.empty()) std::copy_if(set.begin(), set.end(), std::back_inserter(first_), [](const RecordingQuestion& q) { return q.changes_recording(); });
    if (!first_.empty() && with_first_.empty()) with_first_.push_back(name);
  }

  void apply_to_held_out(const std::string& name) {
    if (!has_first_mistakes(name)) examine(name);
  }

  MendedSetUp result() {
    const auto also = [this](const Examined& one) { return one.applied.empty() && has_first_mistakes(one.name); };
    examined_.erase(std::remove_if(examined_.begin(), examined_.end(), also), examined_.end());
    for (const Examined& one : examined_) {
      adopt_corrections(one.applied, one.name);
      for (const QualityFinding& f : one.answers.findings) {
        if (f.severity != Severity::kFault) continue;
        all_.push_back(f);
        all_.back().file = one.name;
        if (is_contradiction(f)) all_.back().sentence += of_some_recordings(one);
      }
    }
    for (const std::string& name : with_first_) adopt_corrections(first_, name);
    out_.findings = once_each(all_);
    return std::move(out_);
  }

 private:
  struct Examined {
    std::string name;
    RobotAnswers answers;
    std::vector<RecordingQuestion> applied;
  };

  // A mistake in the set-up affects every recording. If one recording has an unexplained error but no
  // contradiction, others are tested only if their error is several times as large.
  void examine(const std::string& name) {
    examined_.push_back({name, answers_of(out_.arm, name, options_, identifying::numbers.outstanding * least_left_), {}});
    const RobotAnswers& answers = examined_.back().answers;
    const bool found = std::any_of(answers.findings.begin(), answers.findings.end(), [](const QualityFinding& f) { return f.severity == Severity::kFault; });
    if (!found && !answers.explained && answers.left > 0.0 && (least_left_ == 0.0 || answers.left < least_left_)) least_left_ = answers.left;
  }

  // True if the recording has the mistakes that were found first. Factors that each recording fitted for itself
  // would make recordings of one arm differ, so that the same ones are applied to all.
  bool has_first_mistakes(const std::string& name) {
    if (first_.empty() || !would_explain(first_, out_.arm, name, options_)) return false;
    with_first_.push_back(name);
    return true;
  }

  // Says that options, which count for all recordings, are no remedy where one does not have these mistakes.
  std::string of_some_recordings(const Examined& one) const {
    const std::vector<RecordingQuestion>& set = one.answers.set;
    if (set.empty() || any_changes_robot(set)) return "";
    const bool is_first = !with_first_.empty() && with_first_.front() == one.name;
    std::string files = one.name;
    for (std::size_t k = 1; is_first && k < with_first_.size(); ++k) files += ", " + with_first_[k];
    for (const Examined& other : examined_) {
      if (other.name != one.name && fits_better_without(set, out_.arm, other.name, options_))
        return " " + other.name + " does not have this mistake, and options count for all recordings: change " + files + ".";
    }
    return "";
  }

  void adopt_corrections(const std::vector<RecordingQuestion>& set, const std::string& name) {
    if (set.empty()) return;
    out_.mended = true;
    if (std::none_of(set.begin(), set.end(), [](const RecordingQuestion& q) { return q.changes_recording(); })) return;
    const Recording* there = find_in_memory(options_.in_memory, name);
    Recording recording = there != nullptr ? *there : read_rows(name, recording_options_for(out_.arm, options_), options_.kept.get());
    recording.source = name;
    set_torques_from_currents(out_.arm, recording);
    apply_to(set, out_.arm, recording);
    out_.recordings[name] = std::make_shared<const Recording>(std::move(recording));
  }

  const PreprocessingOptions& options_;
  MendedSetUp out_;
  std::vector<Examined> examined_;
  std::vector<RecordingQuestion> first_;  // the set that was found first
  std::vector<std::string> with_first_;   // recordings that it corrects
  std::vector<QualityFinding> all_;
  double least_left_ = 0.0;  // smallest error among recordings that are neither explained nor contradict the arm
};

// True for mistakes in positions and velocities, false for those in torques, times or the robot file.
bool is_of_motion(const QualityFinding& finding) {
  static const std::set<QualityKind> kNames = {QualityKind::kPositionSign, QualityKind::kSwappedJoints, QualityKind::kDegrees, QualityKind::kTurns, QualityKind::kMillimetres, QualityKind::kCounts, QualityKind::kShareOfRange, QualityKind::kEncoderZero, QualityKind::kMotorSide, QualityKind::kGivenUnit};
  // Degrees in velocities alone are an error of that signal.
  return kNames.count(finding.kind) > 0 && (finding.kind != QualityKind::kDegrees || finding.signal.empty());
}

bool is_large(const PredictionError& e) { return e.relative.size() > 0 && e.relative.maxCoeff() > checking::kCheckAboveError; }

}  // namespace

MendedSetUp mended_set_up(const Model& arm, const std::vector<std::string>& train, const std::vector<std::string>& test,
                          const PreprocessingOptions& options, const Identification& fit) {
  SetUp out(arm, options);
  if (!is_large(fit.train_error) && !is_large(fit.test_error)) return out.result();
  for (const std::string& name : train) out.learn_from(name);
  for (const std::string& name : test) {
    if (std::find(train.begin(), train.end(), name) == train.end()) out.apply_to_held_out(name);
  }
  return out.result();
}

std::vector<QualityFinding> contradictions_in(const Model& arm, const std::vector<std::string>& train, const std::vector<std::string>& test,
                                               const PreprocessingOptions& options, const Identification& fit) {
  return mended_set_up(arm, train, test, options, fit).findings;
}

bool is_contradiction(const QualityFinding& finding) {
  static const std::set<QualityKind> kOthers = {QualityKind::kTorqueSign, QualityKind::kTorqueUnit, QualityKind::kTorqueClock, QualityKind::kTorqueDelay, QualityKind::kTorqueFilter, QualityKind::kChangedMidway, QualityKind::kCurrent, QualityKind::kNoSign, QualityKind::kBrakes, QualityKind::kGravity, QualityKind::kDhConvention, QualityKind::kUnexplained, QualityKind::kRateContradiction, QualityKind::kSameColumn};
  return finding.severity == Severity::kFault && (is_of_motion(finding) || kOthers.count(finding.kind) > 0);
}

std::vector<QualityFinding> merged_findings(std::vector<QualityFinding> contradictions, const std::vector<QualityFinding>& quality) {
  const bool explained = std::any_of(contradictions.begin(), contradictions.end(), [](const QualityFinding& f) { return is_contradiction(f) && is_of_motion(f); });
  const auto of_columns = [](const QualityFinding& f) { return f.kind == QualityKind::kNoSign || f.kind == QualityKind::kSameColumn || f.kind == QualityKind::kZeroSignal; };
  if (std::any_of(quality.begin(), quality.end(), of_columns))
    contradictions.erase(std::remove_if(contradictions.begin(), contradictions.end(), [](const QualityFinding& f) { return f.kind == QualityKind::kUnexplained || f.kind == QualityKind::kNoSign; }), contradictions.end());
  for (const QualityFinding& f : quality) {
    const bool same = f.kind == QualityKind::kDegrees || f.kind == QualityKind::kVelocityScale || f.kind == QualityKind::kVelocitySign || f.kind == QualityKind::kRateContradiction;
    if (!explained || !same) contradictions.push_back(f);
  }
  // Rows that cannot be right are the cause of what does not fit the robot.
  const auto rank = [](const QualityFinding& f) { return std::pair(-static_cast<int>(f.severity), f.kind != QualityKind::kJumps && f.kind != QualityKind::kOverflow); };
  std::stable_sort(contradictions.begin(), contradictions.end(), [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  return contradictions;
}

}  // namespace veridyn
