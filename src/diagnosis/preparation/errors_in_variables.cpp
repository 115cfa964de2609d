#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/numerics.hpp"
#include "diagnosis/preparation/diagnosis_state.hpp"
#include "identification/base_solution.hpp"
#include "identification/instrumental.hpp"

// Noise in positions, velocities and accelerations biases least squares. Where a motion repeats, the columns
// of another repeat serve as instruments: they have the same motion and other noise.

namespace veridyn {

void check_errors_in_variables(DiagnosisState& x) {
  if (x.d.changes || !x.start.model || x.start.factors.empty()) return;
  const Model& arm = *x.start.model;
  const BaseParameters base = base_parameters(arm);
  const std::vector<int>& independent = base.independent;
  const std::vector<SquareRootInformation> joints = joint_totals(x.start.factors);
  VectorXd weights = VectorXd::Zero(arm.joints());
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    const double torque2 = joints[i].z().squaredNorm() + joints[i].rho2();
    if (torque2 == 0.0) continue;  // no torque was recorded
    const double error2 = std::pow(x.start.train_error.relative[i], 2) * torque2;
    weights[i] = std::sqrt(joints[i].rows() / std::max(error2, numerics::kTiny));
  }
  const InstrumentalContrast found =
      contrast_with_repeats(arm, x.start.factors, base, weights, x.options.identification.preprocessing);
  const double limit =
      x.options.thresholds.significance / static_cast<double>(independent.size());
  const std::vector<std::string> names = parameter_names(standard_parameters(arm));
  std::vector<Eigen::Index> differ;
  for (Eigen::Index k = 0; k < found.p_value.size(); ++k) {
    if (found.p_value[k] < limit) differ.push_back(k);
  }
  if (differ.empty()) return;
  std::sort(differ.begin(), differ.end(), [&](Eigen::Index a, Eigen::Index b) {
    return found.p_value[a] < found.p_value[b];
  });
  QualityFinding f;
  f.file = x.train.front();
  f.kind = QualityKind::kErrorsInVariables;
  f.value = static_cast<double>(differ.size());
  f.unit = "parameters";
  f.share = f.value / static_cast<double>(independent.size());
  f.severity = Severity::kWarning;
  f.sentence = fmt::format(
      "noise in the motion biases least squares: of {} base parameters {} differ from the "
      "instrumental-variable estimate (Durbin-Wu-Hausman)",
      independent.size(), differ.size());
  for (size_t k = 0; k < std::min(numerics::kNamedParameters, differ.size()); ++k) {
    const Eigen::Index at = differ[k];
    f.sentence += fmt::format("{} {} {:.4g} against {:.4g} (p = {:.0e})", k == 0 ? ":" : ",",
                              names[independent[at]],
                              found.least_squares[at], found.instrumental[at], found.p_value[at]);
  }
  for (RecordingQuality& q : x.d.data_quality) {
    if (q.file == f.file) q.findings.push_back(f);
  }
}

}  // namespace veridyn
