#include <algorithm>
#include <optional>
#include <string>

#include "diagnosis/stages/diagnosis_state.hpp"
#include "veridyn/effects/effect.hpp"

// The written model is worse than the baseline on no joint of the held-out recordings: they have a veto.

namespace veridyn {
namespace {

// Largest relative rise of a joint's held-out error, and that joint.
std::pair<double, int> largest_rise(const Diagnosis& d) {
  const VectorXd& before = d.baseline.test_error.relative;
  const VectorXd& after = d.extended.test_error.relative;
  std::pair<double, int> out{0.0, -1};
  if (!d.extended.model || before.size() == 0 || before.size() != after.size()) return out;
  for (int j = 0; j < before.size(); ++j) {
    if (before[j] > 0.0) out = std::max(out, {after[j] / before[j] - 1.0, j});
  }
  return out;
}

// The confirmed name on this joint that spoils its held-out error most; one of the whole arm if there is none.
std::optional<size_t> worst_name(const Diagnosis& d, int joint) {
  std::optional<size_t> out;
  double most = 0.0;
  for (const bool whole : {false, true}) {
    for (size_t k = 0; k < d.findings.size() && (!whole || !out); ++k) {
      const Finding& f = d.findings[k];
      if (f.shape || f.status != FindingStatus::kConfirmed || f.test_after.size() <= joint || f.test_outside.size() > 0)
        continue;
      if (whole ? f.joint.has_value() : f.joint != JointIndex{joint}) continue;
      const double loss = f.test_after[joint] - f.test_before[joint];
      if (loss <= most) continue;
      most = loss;
      out = k;
    }
  }
  return out;
}

}  // namespace

void refuse_contradicted(DiagnosisState& x) {
  if (x.options.extended != ExtendedModel::kConfirmedOnly) return;
  const Thresholds& limits = x.options.thresholds;
  for (int turn = 0; turn < limits.withdrawals; ++turn) {
    const auto [rise, joint] = largest_rise(x.d);
    if (rise <= limits.held_out_worse) return;
    const std::optional<size_t> worst = worst_name(x.d, joint);
    if (!worst) return;
    const Finding& f = x.d.findings[*worst];
    const NotSupported lost{f.cause, f.p_value, "the held-out recordings of its joint are predicted worse with it"};
    DiagnosisState y = x;
    y.not_asked.insert(to_text(x.arm, f.cause));
    y.start = y.d.baseline;
    begin_tests(y);
    correct_constants(y);
    select_causes(y);
    if (!y.d.extended.model) return;
    account_for_errors(y);
    if (largest_rise(y.d).first >= rise) return;
    y.d.not_supported.insert(y.d.not_supported.begin(), lost);
    x = std::move(y);
  }
}

}  // namespace veridyn
