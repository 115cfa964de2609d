#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/evidence/numerics.hpp"
#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Signals on which a residual may depend.
enum class SignalKind { kPosition, kVelocity, kAcceleration, kTorque, kHistory, kTime };

/// One signal of a recorded motion. Model torque is the model's prediction; a history is the signed
/// travel since the last reversal, transformed by history_coordinate().
struct MotionSignal {
  SignalKind kind = SignalKind::kPosition;
  std::optional<int> joint = {};  ///< nothing: time
  std::string name;  ///< "q1", "dq1", "ddq1", "tau1", "history1", "t"
  std::string unit;
  double low = 0.0, high = 0.0;  ///< range in the training recordings
  double unit_travel = 1.0;      ///< of a history: the travel at which the coordinate bends
};

/// sign(x) ln(1 + |x| / unit_travel), which resolves small displacements after a reversal as well
/// as large ones.
double history_coordinate(double travel, double unit_travel);
double travel_of_history(double coordinate, double unit_travel);

/// Rows of several recordings with what every joint's model leaves unexplained.
struct MotionRows {
  std::vector<MotionSignal> signals;
  MatrixXd values;    ///< (rows x signals)
  MatrixXd residual;  ///< (rows x n) measured minus modelled, filtered
  MatrixXd measured;  ///< (rows x n)
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> used;  ///< (rows x n): not excluded
  size_t recordings = 0;
  std::vector<size_t> recording;  ///< of every row
  std::vector<double> phase;      ///< of every row: 0 to 1 along its recording, or along each of its periods
};

/// Fold of every row: rows of one are held out together. Recordings are the folds, or phases of few.
std::vector<int> folds_of(const MotionRows& rows, const Thresholds& limits);

/// The signals of the joints that move, from the series of an identification.
std::vector<MotionSignal> motion_signals(const Identification& id, const Thresholds& limits);

/// Rows of its training or test recordings, at a few times the filter's cut-off.
MotionRows motion_rows(const Identification& id, const std::vector<RecordingError>& recordings,
                       const std::vector<ExcludedInterval>& excluded_intervals, std::vector<MotionSignal> signals);

}  // namespace veridyn
