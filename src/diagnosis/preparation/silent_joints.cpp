#include <algorithm>
#include <utility>

#include "diagnosis/preparation/diagnosis_state.hpp"
#include "identification/silent_joints.hpp"
#include "math/correlated_columns.hpp"

// Joints without recorded torque are left out: their zeros would bias the parameters that they share with other joints.

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
  const std::vector<int> silent(x.silent.begin(), x.silent.end());
  end_without_verdicts(x, "joints without torque: " + numbers_from_one(silent) + ", and the others alone do not determine the arm");
  return false;
}

}  // namespace veridyn
