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

  // Factors that each recording fitted for itself would make recordings of one arm differ: the set of the first one is used
  // where it corrects the others, too.
  void learn_from(const std::string& name) {
    RobotAnswers answers = answers_of(out_.arm, name, options_, smallest_error());
    note_faults(answers, name);
    std::vector<RecordingQuestion>& set = answers.set;
    if (!first_.empty() && !answers.explained && would_explain(first_, out_.arm, name, options_)) set = first_;
    set.erase(std::remove_if(set.begin(), set.end(), [this](const RecordingQuestion& q) { return is_left_to_a_diagnosis(q, out_.arm); }), set.end());
    adopt_corrections(set, name);
    if (!first_.empty()) return;
    std::copy_if(set.begin(), set.end(), std::back_inserter(first_), [](const RecordingQuestion& q) { return q.changes_recording(); });
  }

  // Applies the transformations of the training recordings to a held-out recording if they correct it;
  // otherwise reports its contradictions.
  void apply_to_held_out(const std::string& name) {
    if (!first_.empty() && would_explain(first_, out_.arm, name, options_)) adopt_corrections(first_, name);
    else note_faults(answers_of(out_.arm, name, options_, smallest_error()), name);
  }

  MendedSetUp result() {
    out_.findings = once_each(all_);
    for (QualityFinding& f : out_.findings) {
      const bool elsewhere = std::any_of(sound_.begin(), sound_.end(), [&](double left) { return left < identifying::numbers.outstanding * std::max(f.value, checking::kExact); });
      if (elsewhere && is_contradiction(f) && f.kind != QualityKind::kUnexplained && f.kind != QualityKind::kGravity && f.kind != QualityKind::kDhConvention)
        f.sentence += " Other recordings of this command do not have this mistake, and options count for all: change this file.";
    }
    return std::move(out_);
  }

 private:
  // A mistake in the set-up affects every recording. If one recording has an unexplained error but no
  // contradiction, others are tested only if their error is several times as large.
  double smallest_error() const { return identifying::numbers.outstanding * least_left_; }

  void note_faults(const RobotAnswers& answers, const std::string& name) {
    bool found = false;
    for (const QualityFinding& f : answers.findings) {
      if (f.severity != Severity::kFault) continue;
      all_.push_back(f);
      all_.back().file = name;
      found = true;
    }
    if (found || answers.left == 0.0) return;
    sound_.push_back(answers.left);
    if (!answers.explained && (least_left_ == 0.0 || answers.left < least_left_)) least_left_ = answers.left;
  }

  void adopt_corrections(const std::vector<RecordingQuestion>& set, const std::string& name) {
    if (set.empty()) return;
    out_.mended = true;
    if (any_changes_robot(set)) out_.arm = corrected_arm(set, out_.arm);
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
  std::vector<RecordingQuestion> first_;  // the set that was found first
  std::vector<QualityFinding> all_;
  double least_left_ = 0.0;  // smallest error among recordings that are neither explained nor contradict the arm
  std::vector<double> sound_;  // errors of recordings without contradiction
};

// True for mistakes in positions and velocities, false for those in torques, times or the robot file.
bool is_of_motion(const QualityFinding& finding) {
  static const std::set<QualityKind> kNames = {QualityKind::kPositionSign, QualityKind::kSwappedJoints, QualityKind::kDegrees, QualityKind::kTurns, QualityKind::kMillimetres, QualityKind::kCounts, QualityKind::kShareOfRange, QualityKind::kEncoderZero, QualityKind::kMotorSide};
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
  std::stable_sort(contradictions.begin(), contradictions.end(), [](const auto& a, const auto& b) { return a.severity > b.severity; });
  return contradictions;
}

}  // namespace veridyn
