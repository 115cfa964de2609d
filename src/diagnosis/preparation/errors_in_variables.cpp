#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/preparation/instruments.hpp"
#include "diagnosis/numerics.hpp"
#include "diagnosis/preparation/diagnosis_state.hpp"
#include "veridyn/identification/regressor_columns.hpp"

// Noise in positions, velocities and accelerations biases least squares. Where a motion repeats, the
// columns of another repeat are instruments: the same motion, other noise.

namespace veridyn {
namespace {

// Base columns of one recording and joint.
struct Rows {
  MatrixXd A;
  VectorXd b, time;
};

void append(const JointRows& from, const std::vector<int>& independent, Rows& to) {
  const Eigen::Index at = to.b.size();
  const Eigen::Index more = from.b.size();
  to.A.conservativeResize(at + more, static_cast<Eigen::Index>(independent.size()));
  to.A.bottomRows(more).setZero();
  to.b.conservativeResize(at + more);
  to.time.conservativeResize(at + more);
  to.b.tail(more) = from.b;
  to.time.tail(more) = from.time;
  for (size_t k = 0; k < independent.size(); ++k) {
    for (size_t c = 0; c < from.parameters.size(); ++c) {
      if (from.parameters[c] == independent[k])
        to.A.bottomRows(more).col(k) =
            from.A.col(c);
    }
  }
}

// Every row with the row one period later, or earlier where there is no later one.
void pair_up(const Rows& rows, double period, int first_cluster, RepeatedRows& out) {
  std::vector<std::pair<Eigen::Index, Eigen::Index>> pairs;
  const double* begin = rows.time.data();
  const double* end = begin + rows.time.size();
  const double step =
      rows.time.size() > 1 ? (rows.time[rows.time.size() - 1] - rows.time[0]) /
                                 static_cast<double>(rows.time.size() - 1)
                           : 1.0;
  for (Eigen::Index r = 0; r < rows.time.size(); ++r) {
    for (const double shift : {period, -period}) {
      const double* at = std::lower_bound(begin, end, rows.time[r] + shift - 0.5 * step);
      if (at == end || std::abs(*at - rows.time[r] - shift) > 0.5 * step) continue;
      pairs.emplace_back(r, at - begin);
      break;
    }
  }
  const Eigen::Index start = out.b.size();
  const auto more = static_cast<Eigen::Index>(pairs.size());
  out.A.conservativeResize(start + more, rows.A.cols());
  out.Z.conservativeResize(start + more, rows.A.cols());
  out.b.conservativeResize(start + more);
  for (Eigen::Index k = 0; k < more; ++k) {
    const auto [own, other] = pairs[k];
    out.A.row(start + k) = rows.A.row(own);
    out.Z.row(start + k) = rows.A.row(other);
    out.b[start + k] = rows.b[own];
    const double turns = rows.time[own] / period;
    out.cluster.push_back(first_cluster +
                          static_cast<int>(numerics::kPhases * (turns - std::floor(turns))));
  }
}

// Rows of all training recordings whose motion repeats.
std::vector<RepeatedRows> repeated_rows(const DiagnosisState& x, const Model& arm,
                                        const std::vector<int>& independent) {
  std::vector<RepeatedRows> out(arm.joints());
  const PreprocessingOptions& how = x.options.identification.preprocessing;
  int recordings = 0;
  for (const CompressedRecording& r : x.start.factors) {
    if (r.period.seconds <= 0.0) continue;
    std::vector<Rows> joints(out.size());
    PreprocessingOptions of_one = how;
    of_one.excluded_intervals.clear();
    for (const ExcludedInterval& part : how.excluded_intervals) {
      if (part.source == r.source) of_one.excluded_intervals.push_back(part);
    }
    const RegressorColumns columns(arm, of_one);
    for_each_segment(arm, r.source, of_one, [&](const Segment& s) {
      const std::vector<JointRows> rows = columns.rows(s);
      for (size_t i = 0; i < joints.size(); ++i) append(rows[i], independent, joints[i]);
    });
    for (size_t i = 0; i < joints.size(); ++i)
      pair_up(joints[i], r.period.seconds, numerics::kPhases * recordings, out[i]);
    ++recordings;
  }
  return out;
}

// Keeps the parameters that joints with a weight show: friction of the others shows nowhere.
void keep_visible(const VectorXd& weights, std::vector<RepeatedRows>& joints, std::vector<int>& independent) {
  VectorXd squares = VectorXd::Zero(independent.size());
  for (size_t j = 0; j < joints.size(); ++j) {
    if (weights[j] > 0.0) squares += joints[j].A.colwise().squaredNorm().transpose();
  }
  std::vector<int> kept;
  std::vector<int> parameters;
  for (Eigen::Index k = 0; k < squares.size(); ++k) {
    if (squares[k] == 0.0) continue;
    kept.push_back(static_cast<int>(k));
    parameters.push_back(independent[k]);
  }
  independent = std::move(parameters);
  for (RepeatedRows& rows : joints) {
    rows.A = MatrixXd(rows.A(Eigen::all, kept));
    rows.Z = MatrixXd(rows.Z(Eigen::all, kept));
  }
}

}  // namespace

void check_errors_in_variables(DiagnosisState& x) {
  if (x.d.changes || !x.start.model) return;
  const Model& arm = *x.start.model;
  std::vector<int> independent = base_parameters(arm).independent;
  std::vector<RepeatedRows> joints = repeated_rows(x, arm, independent);
  VectorXd weights = VectorXd::Zero(arm.joints());
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    const RepeatedRows& rows = joints[i];
    if (rows.b.norm() == 0.0) continue;  // no torque was recorded
    if (rows.b.size() < 2 * static_cast<Eigen::Index>(independent.size())) return;
    const double error = x.start.train_error.relative[i] * rows.b.norm();
    weights[i] = static_cast<double>(rows.b.size()) / std::max(error * error, numerics::kTiny);
  }
  if ((weights.array() == 0.0).all()) return;
  keep_visible(weights, joints, independent);
  const InstrumentalEstimate found = compare_with_instruments(joints, weights);
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
  f.finding = "errors_in_variables";
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
