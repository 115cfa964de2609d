#include "veridyn/identification/rest_poses.hpp"

#include <cmath>

#include "identification/identification_numbers.hpp"
#include "many_recordings.hpp"
#include "identification/velocity_choice.hpp"
#include "recordings/kept_recordings.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/joint_sensors.hpp"

namespace veridyn {
namespace {

RecordingOptions pose_reading_options(const Model& arm, const PreprocessingOptions& how, double rate) {
  RecordingOptions reading = recording_options_for(arm, how);
  if (reading.rate <= 0.0) reading.rate = rate;  // rate of a file without time
  reading.first_row = how.first_row;
  reading.row_count = how.row_count;
  return reading;
}

bool is_zero_or_missing(const MatrixXd& m) { return (m.array() == 0.0 || m.array().isNaN()).all(); }

// True if all values are -1, 0, 1 or missing.
bool has_only_signs(const MatrixXd& m) {
  return (m.array() == 0.0 || m.array().abs() == 1.0 || m.array().isNaN()).all();
}

// The rows with finite positions and torques, or currents where there are no torques.
Recording without_gaps(const Model& arm, const Recording& r) {
  const int n = arm.joints();
  require(r.joints() == n, r.source, ": found ", r.joints(), " joints, expected the ", n, " of robot '",
          arm.name(), "'.");
  const bool torques = r.tau.size() > 0;
  require(torques || r.current.size() > 0, r.source, ": found neither torques (tau1..tau", n,
          ") nor motor currents (i1..i", n, ").");
  if (!torques) JointSensors(arm).require_drive_gains(arm, r.source);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < r.rows(); ++k) {
    if (r.q.row(k).allFinite() && (torques ? r.tau : r.current).row(k).allFinite()) kept.push_back(k);
  }
  require(!kept.empty(), r.source, ": found no row with finite positions and torques.");
  Recording out;
  out.time = r.time(kept);
  for (const RecordingSignal& signal : {kRecordingSignals[0], kRecordingSignals[1], kRecordingSignals[torques ? 3 : 4]}) {
    const MatrixXd& values = r.*signal.values;
    if (values.size() > 0) out.*signal.values = values(kept, Eigen::all);
  }
  return out;
}

// One pose for each segment without motion. A missing velocity does not count as rest. Where rows were
// excluded, or recordings joined, another position begins another pose with an unknown approach.
Recording poses_between_motions(const Model& arm, const Recording& r) {
  const int n = arm.joints();
  const auto still = [&](int j) {
    return arm.coordinates()[j].prismatic ? identifying::numbers.still_sliding : identifying::numbers.still_turning;
  };
  const auto is_elsewhere = [&](Eigen::Index k, int j) {
    const double travel = arm.coordinates()[j].prismatic ? identifying::numbers.still_prismatic : identifying::numbers.still_revolute;
    return std::abs(r.q(k, j) - r.q(k - 1, j)) > travel;
  };
  const MatrixXd& torque = r.tau.size() > 0 ? r.tau : r.current;
  Recording out;
  Eigen::RowVectorXd last = Eigen::RowVectorXd::Zero(n);
  std::vector<Eigen::RowVectorXd> q, tau, approach;
  Eigen::Index first = 0;
  const auto end_at = [&](Eigen::Index k, Eigen::Index next) {
    const Eigen::Index count = k - first;
    first = next;
    if (count < identifying::numbers.fewest_rows) return;
    q.emplace_back(r.q.middleRows(k - count, count).colwise().mean());
    tau.emplace_back(torque.middleRows(k - count, count).colwise().mean());
    approach.push_back(last);
  };
  for (Eigen::Index k = 0; k < r.rows(); ++k) {
    bool rests = true, jumped = false;
    for (int j = 0; j < n; ++j) {
      rests = rests && std::abs(r.dq(k, j)) <= still(j);
      jumped = jumped || (k > first && is_elsewhere(k, j));
    }
    if (rests && !jumped) continue;
    end_at(k, rests ? k : k + 1);
    for (int j = 0; j < n; ++j) {
      if (std::abs(r.dq(k, j)) > still(j)) {
        last[j] = r.dq(k, j) > 0.0 ? 1.0 : -1.0;
      } else if (rests && is_elsewhere(k, j)) {
        last[j] = 0.0;
      }
    }
  }
  end_at(r.rows(), r.rows());
  const auto rows = static_cast<Eigen::Index>(q.size());
  out.q.resize(rows, n);
  out.dq.resize(rows, n);
  MatrixXd& held = r.tau.size() > 0 ? out.tau : out.current;
  held.resize(rows, n);
  for (Eigen::Index k = 0; k < rows; ++k) {
    out.q.row(k) = q[k];
    held.row(k) = tau[k];
    out.dq.row(k) = approach[k];
  }
  return out;
}

}  // namespace

Recording read_rest_poses(const Model& arm, const std::string& path, const PreprocessingOptions& how,
                          std::optional<double> approach) {
  const Recording* there = find_in_memory(how.in_memory, path);
  Recording out = without_gaps(arm, there != nullptr ? *there : read_recording(path, pose_reading_options(arm, how, 1.0)));
  if (out.dq.size() == 0) out.dq = MatrixXd::Zero(out.rows(), arm.joints());
  if (!is_zero_or_missing(out.dq) && !has_only_signs(out.dq)) out = poses_between_motions(arm, out);
  const auto poses = out.q.rows();
  require(poses > 0, path, ": found no moment at which all joints rest, expected poses at rest.");
  out.source = path;
  out.poses = true;
  out.time = VectorXd::LinSpaced(poses, 0.0, static_cast<double>(poses - 1));
  out.dq = out.dq.array().isNaN().select(0.0, out.dq);
  if (approach) out.dq.setConstant(*approach);
  return out;
}

bool is_at_rest(const Model& arm, const std::string& path, const PreprocessingOptions& how) {
  if (find_in_memory(how.in_memory, path) != nullptr) return false;
  const OpenedRows rows = open_rows(path, recording_options_for(arm, how), how.kept.get());
  Recording piece = rows.next(identifying::kRestPiece);
  if (piece.rows() == 0 || piece.dq.size() == 0) return false;
  const Eigen::RowVectorXd first = piece.q.row(0);
  bool one_pose = true;  // one pose alone does not determine gravity
  while (piece.rows() > 0 && is_zero_or_missing(piece.dq)) {
    one_pose = one_pose && is_zero_or_missing(piece.q.rowwise() - first);
    piece = rows.next(identifying::kRestPiece);
  }
  if (piece.rows() > 0 || one_pose) return false;
  return trust_in_velocities(quick_quality(arm, {path}, how, 1)).wrong.empty();
}

}  // namespace veridyn
