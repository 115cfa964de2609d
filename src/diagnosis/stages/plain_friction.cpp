#include <algorithm>
#include <set>

#include "diagnosis/candidates/candidates.hpp"
#include "diagnosis/findings/findings.hpp"
#include "diagnosis/stages/diagnosis_state.hpp"

// Adds plain friction to a robot file without friction, as manufacturers publish them, on all
// joints together. Tested one at a time, the first joint's friction would be fitted to residuals
// dominated by the others, and be mistaken for a power law or a Stribeck curve.

namespace veridyn {
namespace {

bool along(const Axis& axis, int joint) {
  return std::abs(axis.coefficients[joint]) > (1.0 - numerics::kNoise) * axis.coefficients.norm();
}

// Joints on whose own axis the file has no friction.
std::set<int> joints_without_friction(const Model& arm) {
  std::set<int> out;
  for (int i = 0; i < arm.joints(); ++i) {
    const bool has = std::any_of(arm.effects().begin(), arm.effects().end(), [&](const auto& term) {
      return is_friction(term.effect) && along(term.axis, i);
    });
    if (!has) out.insert(i);
  }
  return out;
}

}  // namespace

void add_plain_friction(DiagnosisState& x) {
  if (x.d.changes) return;
  const std::set<int> joints = joints_without_friction(*x.start.model);
  if (joints.empty()) return;
  CandidateList list = x.list();
  list.wanted.clear();
  for (const std::string& effect : elementary_effects()) {
    if (x.tests_effect(effect)) list.wanted.push_back(effect);
  }
  if (list.wanted.empty()) return;
  CandidateTests asked = prepare_tests(x, list, x.start);
  auto& all = asked.q.augmented.hypotheses;
  all.erase(std::remove_if(all.begin(), all.end(),
                           [&](const Hypothesis& h) {
                             return !h.joint || joints.count(h.joint->value) == 0 ||
                                    columns_of(asked.data, h).empty();
                           }),
            all.end());
  Selection needed = keep_needed(asked.data, asked.q.base, all, x.options);
  if (needed.accepted.empty()) return;
  const Fit fit =
      fit_accepted(x.start, asked.q, needed, x.d.changes, x.train, x.test, x.options);
  const FindingWriter writer(asked.q, asked.data, needed, fit, x.start, x.d.changes, x.options);
  const size_t first = x.d.findings.size();
  writer.add_findings(x.d);
  std::set<size_t> kept;
  for (size_t k = first; k < x.d.findings.size(); ++k) {
    if (x.options.extended == ExtendedModel::kAllFindings ||
        x.d.findings[k].status == FindingStatus::kConfirmed)
      kept.insert(k - first);
  }
  const Identification extended = kept.empty() ? x.start : x.fit(writer.extended_arm(kept));
  if (!extended.model) {
    x.d.findings.resize(first);
    return;
  }
  const std::vector<std::vector<std::string>> names = writer.parameter_names();
  for (const size_t k : kept) x.fitted_by_start[first + k] = names[k];
  x.start = extended;
}

void begin_tests(DiagnosisState& x) {
  x.d.findings.resize(x.contacts);
  x.d.not_supported.clear();
  x.d.cannot_tell.clear();
  x.d.remarks = x.remarks;
  x.fitted_by_start.clear();
  x.refused.clear();
  x.plain_friction = 0;
  add_plain_friction(x);
  x.plain_friction = x.d.findings.size() - x.contacts;
}

}  // namespace veridyn
