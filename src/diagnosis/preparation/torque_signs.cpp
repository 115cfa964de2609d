#include <algorithm>
#include <cmath>

#include "diagnosis/candidates.hpp"
#include "diagnosis/preparation/diagnosis_state.hpp"
#include "identification/base_solution.hpp"
#include "identification/check/check_thresholds.hpp"
#include "veridyn/effects/effect.hpp"

// Friction dissipates power. Significantly negative friction, fitted without sign constraints,
// means that a joint's torque has the wrong sign or belongs to another joint; a small one is what a delay makes of inertia.

namespace veridyn {
namespace {

// Power that one joint's friction terms dissipate, with its deviation, to test its sign.
struct Power {
  double sum = 0.0;       // sum of value * size of the column: torque of friction
  double variance = 0.0;
};

// @param deviations  power of the joint's friction in its standard deviations.
void report_negative_friction(DiagnosisState& x, JointIndex joint, double deviations) {
  const Coordinate& c = x.arm.coordinates()[joint.value];
  QualityFinding f;
  f.file = x.train.front();
  f.kind = QualityKind::kTorqueSign;
  f.signal = "tau";
  f.joint = joint;
  f.value = -deviations;
  f.unit = "standard deviations";
  f.severity = Severity::kFault;
  f.sentence = "friction of joint " + std::to_string(joint.value + 1) + " (" + c.name +
               ") comes out negative beyond doubt: its torque is recorded with the wrong sign, or "
               "is that of another joint; change the sign or the order of the columns";
  for (RecordingQuality& q : x.d.data_quality) {
    if (q.file == f.file) q.findings.insert(q.findings.begin(), f);
  }
}

}  // namespace

void end_without_verdicts(DiagnosisState& x, const std::string& why) {
  Diagnosis& d = x.d;
  d.extended = d.baseline;
  for (int j = 0; j < x.arm.joints(); ++j) {
    JointVerdict v;
    v.joint = JointIndex{j};
    v.held_out = v.extended = v.left = d.baseline.test_error.relative.size() > j ? d.baseline.test_error.relative[j] : 0.0;
    v.source = FloorSource::kRepeats;
    v.floor = d.baseline.noise_floor.size() > j ? std::min(v.held_out, d.baseline.noise_floor[j]) : 0.0;
    v.removable = v.held_out - v.floor;
    v.state = JointState::kCannotTell;
    v.why = why;
    d.joints.push_back(std::move(v));
  }
}

void check_torque_signs(DiagnosisState& x) {
  if (x.d.changes || !x.start.model || x.start.factors.empty()) return;
  const Model& arm = *x.start.model;
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  const std::vector<std::string> names = parameter_names(parameters);
  const BaseParameters base = base_parameters(arm);
  const std::vector<SquareRootInformation> totals = joint_totals(x.start.factors);
  const BaseSolution fit = solve_base(x.start.factors, residual_weights(totals, range_weights(x.start.factors), base, names), base, names);
  const VectorXd sizes = weighted_total(totals, VectorXd::Ones(arm.joints()), names).column_norms();
  std::vector<Power> joints(arm.joints());
  for (size_t k = 0; k < base.independent.size(); ++k) {
    const std::optional<int> e = parameters[base.independent[k]].effect;
    if (!e || !is_friction(arm.effects()[*e].effect)) continue;
    const Axis& axis = arm.effects()[*e].axis;
    if ((axis.coefficients.array() != 0.0).count() != 1) continue;
    const auto at = static_cast<Eigen::Index>(k);
    const double size = sizes[base.independent[k]];
    Power& p = joints[main_coordinate(axis).value];
    p.sum += size * fit.beta[at];
    p.variance += std::pow(size * fit.std[at], 2);
  }
  for (size_t i = 0; i < joints.size(); ++i) {
    const double deviation = std::sqrt(joints[i].variance);
    if (!(deviation > 0.0)) continue;
    const double below = -joints[i].sum / deviation;
    const JointIndex joint{static_cast<int>(i)};
    const bool answered = std::any_of(x.d.data_quality.begin(), x.d.data_quality.end(), [joint](const RecordingQuality& q) {
      return std::any_of(q.findings.begin(), q.findings.end(), [joint](const QualityFinding& f) {
        return f.kind == QualityKind::kTorqueSign && f.joint == joint;
      });
    });
    const bool matters = -joints[i].sum > checking::kFrictionShare * std::sqrt(totals[i].rhs_norm2());
    if (!answered && matters && below > x.options.thresholds.negative_friction) report_negative_friction(x, joint, below);
  }
}

}  // namespace veridyn
