#include <algorithm>
#include <utility>

#include "diagnosis/preparation/diagnosis_state.hpp"
#include "identification/silent_joints.hpp"
#include "model/correlated_joints.hpp"

// Joints without recorded torque are excluded, because their zeros would bias the parameters that they share
// with other joints.

namespace veridyn {

bool exclude_silent_joints(DiagnosisState& x) {
  const std::vector<ExcludedInterval> rows = silent_rows(x.d.baseline.factors);
  if (rows.empty()) return true;
  x.silent = silent_joints(x.d.baseline.factors);
  const size_t parts = x.d.excluded_intervals.size();
  leave_out(rows, x);
  const Model arm = x.d.changes ? x.arm : without_effects_of(x.silent, x.arm);
  Identification without = x.fit(arm);
  if (without.model) {
    x.arm = arm;
    x.d.baseline = std::move(without);
    x.start = x.d.baseline;
    return true;
  }
  x.d.excluded_intervals.resize(parts);
  std::vector<JointIndex> silent;
  for (const int j : x.silent) silent.push_back({j});
  end_without_verdicts(x, "joints without torque: " + numbers_from_one(silent) + ", and the others alone do not determine the arm");
  return false;
}

bool can_attribute_errors(DiagnosisState& x) {
  std::string why;
  for (const std::vector<JointIndex>& group : x.d.moving_as_one) {
    if (!x.d.changes) why += (why.empty() ? "joints " : ", and joints ") + numbers_from_one(group) + " move as one";
  }
  if (!why.empty()) why += " in all training recordings, so that no error can be ascribed to one of them: train on motions in which every joint moves in its own way, as `veridyn excite` makes";
  for (const RecordingQuality& quality : x.d.data_quality) {
    const QualityFinding* f = quality.find(QualityKind::kUnexplained);
    if (why.empty() && f != nullptr && !f->joint && std::find(x.train.begin(), x.train.end(), quality.file) != x.train.end())
      why = "the torques do not follow from the motion of this arm";
  }
  if (!why.empty()) end_without_verdicts(x, why);
  return why.empty();
}

}  // namespace veridyn
