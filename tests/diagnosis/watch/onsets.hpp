#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "support/simulated.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"
#include "veridyn/diagnosis/watch.hpp"

namespace veridyn {

/// A simulated psm-3dof under watch, and what changes in it at chosen times.
struct WatchedArm {
  static constexpr double kRate = 200.0;  // [Hz]
  Model arm = plausible_model(read_model("psm-3dof"), 3).arm;

  /// @param hidden  text forms of effects, as of `simulate --effect`.
  Recording recorded(const MotionSamples& motion, const std::vector<std::string>& hidden,
                     unsigned seed) const {
    SimulationOptions options;
    for (const std::string& one : hidden) options.hidden.push_back(parse_hidden_effect(one));
    options.noise = sensor_noise("low");
    options.seed = seed;
    return recording_of(simulate_recording(arm, motion, options));
  }

  /// All events of a watch that gets the rows in pieces.
  std::vector<WatchEvent> watched(const Recording& recording) const {
    Watch watch(arm);
    for (int k = 0; k < recording.rows(); k += 37)
      watch.add(rows_of(recording, k, std::min(37, recording.rows() - k)));
    watch.finish();
    return watch.events();
  }
};

/// The first recording until `onset` [s], and the second, of the same motion, from then on until
/// `end`.
inline Recording joined(const Recording& before, const Recording& after, double onset, double end) {
  const auto from = static_cast<Eigen::Index>(onset * WatchedArm::kRate);
  const int rows = std::min(before.rows(), static_cast<int>(end * WatchedArm::kRate));
  Recording out = rows_of(before, 0, rows);
  for (const RecordingSignal& signal : kRecordingSignals) {
    MatrixXd& values = out.*signal.values;
    if (values.size() > 0)
      values.bottomRows(rows - from) = (after.*signal.values).middleRows(from, rows - from);
  }
  return out;
}

/// Slow waves of all joints, an overtone each. Their periods have no common multiple within a
/// recording, unless `period` [s] is above zero: then all are whole fractions of it.
inline MotionSamples watched_waves(double seconds, double period = 0.0) {
  const auto rows = static_cast<Eigen::Index>(seconds * WatchedArm::kRate);
  MotionSamples m;
  m.time = VectorXd::LinSpaced(rows, 0.0, (static_cast<double>(rows) - 1.0) / WatchedArm::kRate);
  m.q = m.dq = m.ddq = MatrixXd::Zero(rows, 3);
  const double middle[] = {0.0, 0.0, 0.12};
  const double size[] = {0.6, 0.5, 0.05};
  const double pace[] = {2.1, 1.7, 1.3};  // [rad/s]
  const double whole[] = {3.0, 2.0, 1.0};
  for (int j = 0; j < 3; ++j) {
    for (const double overtone : {1.0, 2.3}) {
      const double w =
          period > 0.0 ? 2.0 * M_PI / period * (overtone > 1.0 ? 2.0 * whole[j] + 1.0 : whole[j])
                       : pace[j] * overtone;
      const double a = size[j] / (2.0 * overtone);
      m.q.col(j).array() += a * (w * m.time.array() + j).sin();
      m.dq.col(j).array() += a * w * (w * m.time.array() + j).cos();
      m.ddq.col(j).array() -= a * w * w * (w * m.time.array() + j).sin();
    }
    m.q.col(j).array() += middle[j];
  }
  return m;
}

/// How a watch answered a change at one onset.
struct OnsetAnswer {
  double onset = 0.0;
  bool right = false;  ///< the first name is the cause, within 3 s, its interval holds the size
  bool impossible = false;  ///< an event whose whole interval is impossible: a negative load
  int changes = 0;          ///< changes reported
  std::string events;       ///< in words
};

inline OnsetAnswer answer(const std::vector<WatchEvent>& events, double onset,
                          const std::string& cause, double size) {
  constexpr double kLatest = 3.0;  // [s]
  OnsetAnswer a;
  a.onset = onset;
  bool named = false;
  for (const WatchEvent& e : events) {
    a.changes = std::max(a.changes, e.id);
    a.impossible = a.impossible || (e.unit == "kg" && e.high < 0.0);
    a.events +=
        std::string(name_of(e.stage)) + " at " + std::to_string(e.time) + ": " + e.sentence + "\n";
    if (e.stage != WatchStage::kNamed || named) continue;
    named = true;
    a.right = e.text == cause && e.time > onset && e.time - onset <= kLatest && e.low < size &&
              size < e.high;
  }
  return a;
}

}  // namespace veridyn
