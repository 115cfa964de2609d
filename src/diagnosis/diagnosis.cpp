#include "veridyn/diagnosis/diagnosis.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "diagnosis/stages/investigation.hpp"
#include "recordings/named_recordings.hpp"

namespace veridyn {
namespace {

bool are_facts(const Model& arm, const DiagnosisOptions& options) {
  return options.values == RobotValues::kFacts && has_all_values(arm);
}

void ask_everything(Investigation& x) {
  x.d.findings.resize(x.contacts);
  x.d.not_supported.clear();
  x.d.cannot_tell.clear();
  x.d.remarks = x.remarks;
  x.fitted_by_start.clear();
  x.refused.clear();
  add_plain_friction(x);
  correct_constants(x);
  select_causes(x);
}

void run_stages(Investigation& x) {
  check_quality(x);
  if (!fit_baseline(x)) return;
  check_torque_signs(x);
  check_errors_in_variables(x);
  exclude_snags(x.start, x);
  ask_everything(x);
  // Contacts and small snags show once the model's own errors are out of the way; then everything
  // is asked anew without these moments.
  const Identification extended = x.d.extended;
  const bool snags = exclude_snags(extended, x);
  const bool contacts = exclude_contacts(extended, x);
  if (snags || contacts) ask_everything(x);
  summarize(x.d, x.options.thresholds);
}

}  // namespace

Diagnosis diagnose(const Model& arm, const Recordings& train, const Recordings& test,
                   const DiagnosisOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const NamedRecordings<IdentificationOptions> named(train, test, options.identification);
  Investigation x{arm, named.train, named.test, options, {}, {}, 0, {}, {}, {}};
  x.options.identification = named.how;
  keep_recordings(x.options.identification, KeptRecordings::kManyQuestions);
  x.d.changes = are_facts(arm, options);
  x.d.provisional = named.train.size() == 1;
  x.d.summary.held_out_untouched = options.extended == ExtendedModel::kAllFindings;
  Thresholds& limits = x.options.thresholds;
  if (x.d.changes) limits.smallest_gain = std::max(limits.smallest_gain, limits.smallest_change);
  run_stages(x);
  forget_recordings(x.d.baseline);
  forget_recordings(x.d.extended);
  x.d.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return std::move(x.d);
}

}  // namespace veridyn
