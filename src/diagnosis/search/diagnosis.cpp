#include "veridyn/diagnosis/diagnosis.hpp"

#include <chrono>
#include <functional>
#include <string>
#include <utility>

#include "diagnosis/findings/summary.hpp"
#include "diagnosis/of_identification.hpp"
#include "diagnosis/preparation/diagnosis_state.hpp"
#include "diagnosis/search/explain.hpp"
#include "recordings/named_recordings.hpp"
#include "identification/check/answers.hpp"
#include "identification/identification_numbers.hpp"
#include "identification/many_recordings.hpp"

namespace veridyn {
namespace {

bool are_facts(const Model& arm) {
  return arm.description().values == RobotValues::kFacts && has_all_values(arm);
}

// The arm of a robot file, with the provenance of its values as given by the caller.
Model robot_of(const Model& file, const DiagnosisOptions& options) {
  ModelDescription d = file.description();
  d.values = options.values.value_or(d.values);
  return Model(std::move(d));
}

// Reports the step that runs now.
using ReportStep = std::function<void(const char* step)>;

// Replaces arm and recordings by those with the corrections applied.
void apply_mended(const MendedSetUp& mended, DiagnosisState& x) {
  IdentificationOptions& how = x.options.identification;
  x.arm = mended.arm;
  for (const auto& [name, recording] : mended.recordings) how.preprocessing.in_memory[name] = recording;
  how.preprocessing.kept.reset();
  if (how.test_preprocessing) how.test_preprocessing->in_memory = how.preprocessing.in_memory;
  keep_recordings(how, KeptRecordings::kManyQuestions);
  x.d.mended = true;
  x.d.baseline = {};
}

// Fits the arm. Reports contradictions between signals and robot file; if a transformation clearly removes
// them, the diagnosis continues with the transformed recordings or arm.
bool fit_mended(DiagnosisState& x, const ReportStep& report_step) {
  const DiagnosisState as_given = x;
  report_step("checking the recordings");
  check_quality(x);
  report_step("fitting the model as it is");
  if (!fit_baseline(x)) return false;
  const MendedSetUp set_up = mended_set_up(as_given.arm, x.train, x.test, x.options.identification.preprocessing, x.d.baseline);
  if (set_up.mended) {
    const std::vector<RecordingQuality> as_read = std::move(x.d.data_quality);
    x = as_given;
    apply_mended(set_up, x);
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

void run(DiagnosisState& x, const ReportStep& report_step) {
  if (!(x.poses ? fit_baseline(x) : fit_mended(x, report_step))) return;
  if (x.poses) x.remarks = x.d.baseline.remarks;
  if (!exclude_silent_joints(x)) return;
  if (!x.poses) exclude_rests(x);
  if (!can_attribute_errors(x)) return;
  check_torque_signs(x);
  check_errors_in_variables(x);
  report_step("searching");
  search::explain(x);
  if (x.poses && !x.d.extended.remarks.empty()) x.d.remarks.back() = x.d.extended.remarks.back();  // the band that remains
  summarize(x.d, x.options);
  if (!x.d.friction_remark.empty()) x.d.friction = plain_friction_of(*x.d.extended.model);
}

// Progress of steps and rounds whose number is not known in advance: each step advances the bar by half of
// the remainder, and each round by half of what remains of its step.
class Halving {
 public:
  using Listener = std::function<void(const std::string&, double)>;

  explicit Halving(Listener listener) : listener_(std::move(listener)) {}

  void begin_step(const char* step) {
    begun_ += width_;
    width_ = 0.5 * (1.0 - begun_);
    rounds_left_ = 1.0;
    step_ = step;
    report_step(step_, begun_);
  }

  void report_test(int tested, int of) {
    const double round = 0.5 * rounds_left_;
    const double done = 1.0 - rounds_left_ + round * tested / of;
    report_step(step_ + ": testing hypothesis " + std::to_string(tested) + " of " + std::to_string(of),
                begun_ + width_ * done);
    if (tested == of) rounds_left_ -= round;
  }

  void report_end() const { report_step("done", 1.0); }

 private:
  void report_step(const std::string& what, double share) const {
    if (listener_) listener_(what, share);
  }

  Listener listener_;
  std::string step_;
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
  DiagnosisState x{robot_of(arm, options), named.train, named.test, options, {}, named.poses};
  x.options.identification = named.how;
  keep_recordings(x.options.identification, KeptRecordings::kManyQuestions);
  for (std::string& one : x.options.effects) one = normalized_cause(arm, one);
  x.d.changes = are_facts(x.arm);
  // The caller's fit, with the joint weights used here: nothing is compressed again.
  if (fitted != nullptr) {
    x.d.baseline = identify_compressed(x.arm, fitted->factors, {}, x.test, x.options.identification);
  }
  x.d.provisional = named.train.size() == 1;
  Halving progress(std::exchange(x.options.identification.progress, {}));
  x.options.testing = [&progress](int tested, int of) { progress.report_test(tested, of); };
  run(x, [&progress](const char* step) { progress.begin_step(step); });
  progress.report_end();
  const Identification& found = x.d.extended.model ? x.d.extended : x.d.baseline;
  if (found.model) x.d.model = *found.model;
  for (Finding& finding : x.d.findings) finding.text = x.d.sentence(finding);
  drop_recordings(x.d.baseline);
  drop_recordings(x.d.extended);
  x.d.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return std::move(x.d);
}

}  // namespace veridyn
