#include "veridyn/diagnosis/diagnosis.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <string>
#include <utility>

#include "diagnosis/search/explain.hpp"
#include "diagnosis/stages/diagnosis_state.hpp"
#include "recordings/named_recordings.hpp"
#include "diagnosis/of_identification.hpp"
#include "identification/check/answers.hpp"
#include "identification/identification_numbers.hpp"
#include "identification/many_recordings.hpp"
#include "veridyn/identification/verdict.hpp"

namespace veridyn {
namespace {

bool are_facts(const Model& arm) {
  return arm.description().values == RobotValues::kFacts && has_all_values(arm);
}

// The arm of a robot file, with the provenance of its values that the caller gives.
Model robot_of(const Model& file, const DiagnosisOptions& options) {
  ModelDescription d = file.description();
  d.values = options.values.value_or(d.values);
  return Model(std::move(d));
}

// Says which stage runs.
using Tell = std::function<void(const char* stage)>;

void test_all_candidates(DiagnosisState& x, const Tell& tell) {
  begin_tests(x);
  tell("trying constants of the robot file");
  correct_constants(x);
  tell("trying causes");
  select_causes(x);
}

// A joint that `identify` calls at the noise is at its floor: where nothing is left to be named, both say the same.
void share_the_verdict(Diagnosis& d) {
  const IdentificationVerdict fit = verdict_of(d.baseline);
  for (size_t i = 0; i < d.joints.size() && i < fit.joints.size(); ++i) {
    JointVerdict& v = d.joints[i];
    if (v.state != JointState::kCannotTell || v.source != FloorSource::kRepeats || fit.joints[i].state != IdentifiedState::kAtFloor) continue;
    v.state = JointState::kAtFloor;
    v.why.clear();
  }
}

void conclude(DiagnosisState& x) {
  share_the_verdict(x.d);
  summarize(x.d, x.options);
  if (!x.d.friction_remark.empty()) x.d.friction = plain_friction_of(*x.d.extended.model);
}

// Exchanges the set-up for the mended one, and begins anew with it.
void take(const MendedSetUp& mended, DiagnosisState& x) {
  IdentificationOptions& how = x.options.identification;
  x.arm = mended.arm;
  for (const auto& [name, recording] : mended.recordings) how.preprocessing.in_memory[name] = recording;
  if (how.test_preprocessing) how.test_preprocessing->in_memory = how.preprocessing.in_memory;
  for (PreprocessingOptions* one : {&how.preprocessing, how.test_preprocessing ? &*how.test_preprocessing : nullptr}) {
    if (one != nullptr) one->kept.reset();
  }
  keep_recordings(how, KeptRecordings::kManyQuestions);
  x.d.mended = true;
  x.d.baseline = {};
}

// What is wrong with the signals or with the robot file is said, and where that is clear the diagnosis goes on without it.
bool fit_what_is_meant(DiagnosisState& x, const Tell& tell) {
  const DiagnosisState as_given = x;
  tell("checking the recordings");
  check_quality(x);
  tell("fitting the model as it is");
  if (!fit_baseline(x)) return false;
  std::vector<std::string> all = x.train;
  for (const std::string& path : x.test) {
    if (std::find(all.begin(), all.end(), path) == all.end()) all.push_back(path);
  }
  const MendedSetUp set_up = mended_set_up(as_given.arm, all, x.options.identification.preprocessing, x.d.baseline);
  if (set_up.mended) {
    const std::vector<RecordingQuality> as_read = std::move(x.d.data_quality);
    x = as_given;
    take(set_up, x);
    check_quality(x);
    for (size_t k = 0; k < as_read.size(); ++k) x.d.data_quality[k].facts = as_read[k].facts;
    if (!fit_baseline(x)) return false;
  }
  for (const QualityFinding& f : set_up.findings) {
    for (RecordingQuality& q : x.d.data_quality) {
      if (q.file == f.file) q.findings.insert(q.findings.begin(), f);
    }
  }
  return true;
}

void run_stages(DiagnosisState& x, const Tell& tell) {
  if (!fit_what_is_meant(x, tell)) return;
  if (!leave_silent_joints_out(x)) return;
  exclude_rests(x);
  check_torque_signs(x);
  check_errors_in_variables(x);
  const bool model_is_given = x.options.method == DiagnosisMethod::kAutomatic && x.d.changes;
  if (x.options.method == DiagnosisMethod::kSearch || model_is_given) {
    tell("searching");
    search::explain(x);
    x.d.small_apart = x.options.extended == ExtendedModel::kConfirmedOnly;
    return conclude(x);
  }
  // Beside a gravity of another direction no joint is known well enough to stick in places.
  const bool leans = std::any_of(x.d.data_quality.begin(), x.d.data_quality.end(), [](const RecordingQuality& q) {
    return std::any_of(q.findings.begin(), q.findings.end(), [](const QualityFinding& f) { return f.finding == "gravity"; });
  });
  if (!leans) exclude_snags(x.start, x);
  test_all_candidates(x, tell);
  // Contacts and small snags are visible once the model's own errors are corrected; then everything
  // is repeated without these intervals.
  const Identification extended = x.d.extended;
  const bool snags = exclude_snags(extended, x);
  const bool contacts = exclude_contacts(extended, x);
  if (snags || contacts) {
    tell("once more, without snags and contacts");
    test_all_candidates(x, tell);
  }
  tell("accounting for what is left over");
  account_for_errors(x);
  test_names_together(x);
  conclude(x);
}

// Progress of stages and rounds of tests whose number is not known before: each stage advances the
// bar by half of the rest, and each round by half of the rest of its stage.
class Halving {
 public:
  using Listener = std::function<void(const std::string&, double)>;

  explicit Halving(Listener listener) : listener_(std::move(listener)) {}

  void begin(const char* stage) {
    begun_ += width_;
    width_ = 0.5 * (1.0 - begun_);
    rounds_left_ = 1.0;
    stage_ = stage;
    tell(stage_, begun_);
  }

  void test(int tested, int of) {
    const double round = 0.5 * rounds_left_;
    const double done = 1.0 - rounds_left_ + round * tested / of;
    tell(stage_ + ": testing hypothesis " + std::to_string(tested) + " of " + std::to_string(of),
         begun_ + width_ * done);
    if (tested == of) rounds_left_ -= round;
  }

  void end() const { tell("done", 1.0); }

 private:
  void tell(const std::string& what, double share) const {
    if (listener_) listener_(what, share);
  }

  Listener listener_;
  std::string stage_;
  double begun_ = 0.0, width_ = 0.0, rounds_left_ = 1.0;
};

}  // namespace

Diagnosis diagnose(const Model& arm, const Recordings& train, const Recordings& test,
                   const DiagnosisOptions& options) {
  return diagnose(arm, train, test, options, nullptr);
}

Diagnosis diagnose(const Model& arm, const Recordings& train, const Recordings& test,
                   const DiagnosisOptions& options, const Identification* fitted) {
  const auto begin = std::chrono::steady_clock::now();
  const NamedRecordings<IdentificationOptions> named(train, test, options.identification);
  DiagnosisState x{robot_of(arm, options), named.train, named.test, options, {}, {}, 0, {}, {}, {}};
  x.options.identification = named.how;
  keep_recordings(x.options.identification, KeptRecordings::kManyQuestions);
  for (std::string& one : x.options.effects) one = normalized_cause(arm, one);
  x.d.changes = are_facts(x.arm);
  // The caller's fit with the joints weighted as here: nothing is compressed again.
  if (fitted != nullptr) {
    x.d.baseline = identify_compressed(x.arm, fitted->factors, {}, x.test, x.options.identification, IdentificationNumbers());
  }
  x.d.provisional = named.train.size() == 1;
  Thresholds& limits = x.options.thresholds;
  if (x.d.changes) limits.smallest_gain = std::max(limits.smallest_gain, limits.smallest_change);
  Halving progress(std::exchange(x.options.identification.progress, {}));
  x.options.testing = [&progress](int tested, int of) { progress.test(tested, of); };
  run_stages(x, [&progress](const char* stage) { progress.begin(stage); });
  progress.end();
  const Identification& found = x.d.extended.model ? x.d.extended : x.d.baseline;
  if (found.model) x.d.model = *found.model;
  for (Finding& finding : x.d.findings) finding.text = x.d.sentence(finding);
  forget_recordings(x.d.baseline);
  forget_recordings(x.d.extended);
  x.d.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return std::move(x.d);
}

}  // namespace veridyn
