#include "identification/check/answers.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "identification/check/check_thresholds.hpp"
#include "recordings/kept_recordings.hpp"
#include "veridyn/identification/robot_check.hpp"

// What the recordings of one command answer together, and the set-up that follows.

namespace veridyn {
namespace {

// One answer for all recordings that give it; where they answer otherwise about one joint, what most of them say.
std::vector<QualityFinding> once_each(const std::vector<QualityFinding>& all) {
  using Key = std::pair<std::string, int>;
  std::map<Key, int> votes;
  for (const QualityFinding& f : all) ++votes[{f.finding, f.joint}];
  std::vector<QualityFinding> out;
  std::set<Key> said;
  for (const QualityFinding& f : all) {
    const int own = votes.at({f.finding, f.joint});
    const bool outvoted = std::any_of(votes.begin(), votes.end(), [&](const auto& other) { return other.first.second == f.joint && other.second > own; });
    if (!outvoted && said.insert({f.finding, f.joint}).second) out.push_back(f);
  }
  return out;
}

// A base that leans is a cause that a diagnosis measures, and so is any other gravity of a MODEL.
bool is_left_to_a_diagnosis(const RecordingQuestion& q, const Model& arm) {
  if (q.finding != "gravity") return false;
  if (arm.description().values == RobotValues::kFacts && has_all_values(arm)) return true;
  const Eigen::Vector3d turned = applied({q}, arm).gravity();
  return turned.dot(arm.gravity()) > checking::kLeaning * turned.norm() * arm.gravity().norm() && !turned.isZero();
}

class SetUp {
 public:
  SetUp(const Model& arm, const PreprocessingOptions& options) : options_(options) { out_.arm = arm; }

  void learn_from(const std::string& name) {
    RobotAnswers answers = answers_of(out_.arm, name, options_, ask_above());
    note(answers, name);
    std::vector<RecordingQuestion>& set = answers.set;
    if (set.empty() && !answers.explained && would_mend(first_, out_.arm, name, options_)) set = first_;
    set.erase(std::remove_if(set.begin(), set.end(), [this](const RecordingQuestion& q) { return is_left_to_a_diagnosis(q, out_.arm); }), set.end());
    mend(set, name);
    if (first_.empty()) first_ = std::move(set);
  }

  // What was learnt, where a held-out recording has it too; a mistake of its own is said.
  void apply_to_held_out(const std::string& name) {
    if (!first_.empty() && would_mend(first_, out_.arm, name, options_)) mend(first_, name);
    else note(answers_of(out_.arm, name, options_, ask_above()), name);
  }

  MendedSetUp result() {
    out_.findings = once_each(all_);
    for (QualityFinding& f : out_.findings) {
      const bool elsewhere = std::any_of(sound_.begin(), sound_.end(), [&](double left) { return left < checking::kOutstanding * std::max(f.value, checking::kExact); });
      if (elsewhere && is_contradiction(f) && f.finding != "unexplained" && f.finding != "gravity" && f.finding != "dh_convention")
        f.sentence += " Other recordings of this command do not have this mistake, and options count for all: change this file.";
    }
    return std::move(out_);
  }

 private:
  // Mistakes of a set-up are in every recording: where one leaves some error and names none, others that leave as much
  // are not asked.
  double ask_above() const { return checking::kOutstanding * least_left_; }

  void note(const RobotAnswers& answers, const std::string& name) {
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

  void mend(const std::vector<RecordingQuestion>& set, const std::string& name) {
    if (set.empty()) return;
    out_.mended = true;
    if (concern_robot(set)) out_.arm = applied(set, out_.arm);
    if (std::none_of(set.begin(), set.end(), [](const RecordingQuestion& q) { return static_cast<bool>(q.recording); })) return;
    const Recording* there = find_in_memory(options_.in_memory, name);
    Recording recording = there != nullptr ? *there : read_rows(name, reading_of(out_.arm, options_), options_.kept.get());
    recording.source = name;
    give_torques(out_.arm, recording);
    apply_to(set, recording);
    out_.recordings[name] = std::make_shared<const Recording>(std::move(recording));
  }

  const PreprocessingOptions& options_;
  MendedSetUp out_;
  std::vector<RecordingQuestion> first_;  // of the recordings alone
  std::vector<QualityFinding> all_;
  double least_left_ = 0.0;  // of recordings that are neither explained nor name a mistake
  std::vector<double> sound_;  // errors of recordings that name none
};

bool is_large(const PredictionError& e) { return e.relative.size() > 0 && e.relative.maxCoeff() > checking::kAskedAbove; }

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
  static const char* const kNames[] = {"torque_sign", "position_sign", "swapped_joints", "degrees", "turns", "millimetres", "counts", "share_of_range", "encoder_zero",
                                       "motor_side", "torque_unit", "current", "gravity", "dh_convention", "unexplained"};
  // Degrees that velocities alone show are those of a signal.
  return finding.severity == Severity::kFault && (finding.finding != "degrees" || finding.signal.empty()) &&
         std::find(std::begin(kNames), std::end(kNames), finding.finding) != std::end(kNames);
}

std::vector<QualityFinding> merged_findings(std::vector<QualityFinding> contradictions, const std::vector<QualityFinding>& quality) {
  const auto of_motion = [](const QualityFinding& f) {
    return is_contradiction(f) && f.finding.rfind("torque", 0) != 0 && f.finding != "current" && f.finding != "gravity" && f.finding != "dh_convention" && f.finding != "unexplained";
  };
  const bool explained = std::any_of(contradictions.begin(), contradictions.end(), of_motion);
  for (const QualityFinding& f : quality) {
    const bool same = f.finding == "degrees" || f.finding == "velocity_scale" || f.finding == "velocity_sign" || f.finding == "rate_contradiction";
    if (!explained || !same) contradictions.push_back(f);
  }
  std::stable_sort(contradictions.begin(), contradictions.end(), [](const auto& a, const auto& b) { return a.severity > b.severity; });
  return contradictions;
}

}  // namespace veridyn
