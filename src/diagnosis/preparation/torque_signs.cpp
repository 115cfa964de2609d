#include <algorithm>
#include <cmath>

#include "diagnosis/candidates.hpp"
#include "diagnosis/findings/held_out.hpp"
#include "diagnosis/load_fit.hpp"
#include "diagnosis/numerics.hpp"
#include "diagnosis/preparation/diagnosis_state.hpp"
#include "math/clustered_statistics.hpp"
#include "math/student_t.hpp"
#include "veridyn/effects/effect.hpp"

// Friction dissipates power. Significantly negative friction, fitted without sign constraints,
// means that a joint's torque has the wrong sign or belongs to another joint.

namespace veridyn {
namespace {

// Dissipated power of one joint's friction terms, with its deviation: its sign is tested.
struct Power {
  double sum = 0.0;       // sum of value * size of the column: torque of friction
  double variance = 0.0;
};

// Least squares without conditions on signs, each joint weighted by its own residual.
class FreeFit {
 public:
  FreeFit(const std::vector<CompressedRecording>& recordings, const std::vector<std::string>& columns, int joints, const HoldOut& how)
      : rows_(recordings, columns, joints), weights_(VectorXd::Zero(joints)) {
    const std::vector<RowSquares>& all = rows_.total();
    const auto weigh = [&](const VectorXd& left) {
      for (size_t i = 0; i < all.size(); ++i)
        weights_[i] = all[i].rows / std::max(left[i], numerics::kNoise * std::max(all[i].bb, numerics::kTiny));
    };
    weigh(squares_left(VectorXd::Zero(columns.size())));
    for (int round = 0; round < 2; ++round) weigh(squares_left(solved({})));
    values_ = solved({});
    // The larger of two jackknifes, over clusters, and over parts of the recordings where there are several: what is
    // systematic to one motion shows only there.
    std::vector<std::vector<int>> clusters, parts;
    for (const CompressedRecording& recording : recordings) {
      const size_t each = how.parts_of_each(recordings.size()), first = clusters.size();
      for (size_t k = 0; k < recording.blocks.size(); ++k) clusters.push_back({static_cast<int>(first + k)});
      for (size_t part = 0; part < each; ++part) {
        std::vector<int> some;
        for (size_t k = part * recording.blocks.size() / each; k < (part + 1) * recording.blocks.size() / each; ++k)
          some.push_back(static_cast<int>(first + k));
        if (!some.empty()) parts.push_back(std::move(some));
      }
    }
    deviations_ = jackknife(clusters);
    if (recordings.size() < 2 || parts.size() < 3) return;
    const double wider = quantile(parts.size() - 1) / quantile(std::max<size_t>(1, clusters.size() - 1));
    deviations_ = deviations_.cwiseMax(wider * jackknife(parts));
  }

  const VectorXd& values() const { return values_; }
  const VectorXd& deviations() const { return deviations_; }
  // Norm of a column over all rows and joints.
  double size(Eigen::Index column) const {
    double out = 0.0;
    for (const RowSquares& joint : rows_.total()) out += joint.AA(column, column);
    return std::sqrt(out);
  }

 private:
  static double quantile(size_t freedom) { return student_t_quantile(numerics::kOutside, static_cast<double>(freedom)); }

  VectorXd squares_left(const VectorXd& x) const {
    VectorXd out(weights_.size());
    for (Eigen::Index i = 0; i < out.size(); ++i) {
      const RowSquares& joint = rows_.total()[i];
      out[i] = std::max(joint.bb - 2.0 * x.dot(joint.Ab) + x.dot(joint.AA * x), 0.0);
    }
    return out;
  }

  // From all rows but those of some clusters.
  VectorXd solved(const std::vector<int>& without) const {
    MatrixXd A = MatrixXd::Zero(rows_.total().front().AA.rows(), rows_.total().front().AA.cols());
    VectorXd b = VectorXd::Zero(A.rows());
    const auto add = [&](const std::vector<RowSquares>& joints, double sign) {
      for (size_t i = 0; i < joints.size(); ++i) {
        A += sign * weights_[i] * joints[i].AA;
        b += sign * weights_[i] * joints[i].Ab;
      }
    };
    add(rows_.total(), 1.0);
    for (const int k : without) add(rows_.cluster(k), -1.0);
    return solve_scaled(A, b);
  }

  VectorXd jackknife(const std::vector<std::vector<int>>& groups) const {
    MatrixXd without(values_.size(), static_cast<Eigen::Index>(groups.size()));
    for (size_t k = 0; k < groups.size(); ++k) without.col(k) = solved(groups[k]);
    return jackknife_deviations(without);
  }

  LoadRows rows_;
  VectorXd weights_, values_, deviations_;
};

void report(DiagnosisState& x, int joint, double deviations) {
  const Coordinate& c = x.arm.coordinates()[joint];
  QualityFinding f;
  f.file = x.train.front();
  f.finding = "torque_sign";
  f.signal = "tau";
  f.joint = joint + 1;
  f.value = -deviations;
  f.unit = "standard deviations";
  f.severity = Severity::kFault;
  f.sentence = "friction of joint " + std::to_string(joint + 1) + " (" + c.name +
               ") comes out negative beyond doubt: its torque is recorded with the wrong sign, or "
               "is that of another joint; change the sign or the order of the columns";
  for (RecordingQuality& q : x.d.data_quality) {
    if (q.file == f.file) q.findings.insert(q.findings.begin(), f);
  }
}

}  // namespace

void cannot_tell_of_all(DiagnosisState& x, const std::string& why) {
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
  if (x.d.changes || !x.start.model) return;
  const Model& arm = *x.start.model;
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  const std::vector<std::string> names = parameter_names(parameters);
  std::vector<std::string> columns;
  const std::vector<int> independent = base_parameters(arm).independent;
  for (const int j : independent) columns.push_back(names[j]);
  const FreeFit fit(x.start.factors, columns, arm.joints(), hold_out(x.options.thresholds));
  std::vector<Power> joints(arm.joints());
  for (size_t k = 0; k < independent.size(); ++k) {
    const std::optional<int> e = parameters[independent[k]].effect;
    if (!e || !is_friction(arm.effects()[*e].effect)) continue;
    const Axis& axis = arm.effects()[*e].axis;
    if ((axis.coefficients.array() != 0.0).count() != 1) continue;
    const auto at = static_cast<Eigen::Index>(k);
    const double size = fit.size(at);
    Power& p = joints[main_coordinate(axis)];
    p.sum += size * fit.values()[at];
    p.variance += std::pow(size * fit.deviations()[at], 2);
  }
  for (size_t i = 0; i < joints.size(); ++i) {
    const double deviation = std::sqrt(joints[i].variance);
    if (deviation <= 0.0) continue;
    const double below = -joints[i].sum / deviation;
    const bool answered = std::any_of(x.d.data_quality.begin(), x.d.data_quality.end(), [i](const RecordingQuality& q) {
      return std::any_of(q.findings.begin(), q.findings.end(), [i](const QualityFinding& f) {
        return f.finding == "torque_sign" && f.joint == static_cast<int>(i) + 1;
      });
    });
    if (!answered && below > x.options.thresholds.negative_friction) report(x, static_cast<int>(i), below);
  }
}

}  // namespace veridyn
