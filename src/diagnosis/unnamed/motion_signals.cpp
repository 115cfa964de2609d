#include "diagnosis/unnamed/motion_signals.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/evidence/folds.hpp"
#include "diagnosis/evidence/numerics.hpp"

namespace veridyn {
namespace {

const char* letter(SignalKind kind) {
  switch (kind) {
    case SignalKind::kPosition: return "q";
    case SignalKind::kVelocity: return "dq";
    case SignalKind::kAcceleration: return "ddq";
    case SignalKind::kTorque: return "tau";
    case SignalKind::kHistory: return "history";
    case SignalKind::kTime: return "t";
  }
  return "";
}

std::string unit_of(SignalKind kind, bool slides) {
  const std::string length = slides ? "m" : "rad";
  switch (kind) {
    case SignalKind::kPosition:
    case SignalKind::kHistory: return length;
    case SignalKind::kVelocity: return length + "/s";
    case SignalKind::kAcceleration: return length + "/s^2";
    case SignalKind::kTorque: return slides ? "N" : "N m";
    case SignalKind::kTime: return "s";
  }
  return "";
}

double largest(const std::vector<double>& x) {
  double out = 0.0;
  for (const double v : x) out = std::max(out, std::abs(v));
  return out;
}

// Signed travel since the last reversal; a joint that hardly moves has not reversed.
std::vector<double> travel_since_reversal(const std::vector<double>& q,
                                          const std::vector<double>& dq, double rest_speed) {
  std::vector<double> out(q.size(), 0.0);
  double from = q.empty() ? 0.0 : q.front();
  double direction = 0.0;
  for (size_t k = 0; k < q.size(); ++k) {
    const double now = std::abs(dq[k]) > rest_speed ? (dq[k] > 0.0 ? 1.0 : -1.0) : direction;
    if (now != direction) {
      direction = now;
      from = k > 0 ? q[k - 1] : q[k];
    }
    out[k] = direction * std::abs(q[k] - from);
  }
  return out;
}

// All values of a signal along one recording's series.
std::vector<double> along(const MotionSignal& signal, const PredictionSeries& x, double rest_speed) {
  const auto j = static_cast<size_t>(signal.joint.value_or(0));
  switch (signal.kind) {
    case SignalKind::kPosition: return x.q[j];
    case SignalKind::kVelocity: return x.dq[j];
    case SignalKind::kAcceleration: return x.ddq[j];
    case SignalKind::kTorque: return x.modelled[j];
    case SignalKind::kTime: return x.time;
    case SignalKind::kHistory: break;
  }
  std::vector<double> out = travel_since_reversal(x.q[j], x.dq[j], rest_speed);
  for (double& v : out) v = history_coordinate(v, signal.unit_travel);
  return out;
}

double rest_speed_of(const Identification& id, int joint) {
  double fastest = 0.0;
  for (const RecordingError& r : id.train)
    fastest = std::max(fastest, largest(r.series.dq[joint]));
  return fastest * numerics::kReversalShare;
}

double phase_of(const RecordingError& r, double time) {
  const double first = r.series.time.front();
  const double length = r.period > 0.0 ? r.period : r.series.time.back() - first;
  return length > 0.0 ? std::fmod(time - first, length) / length : 0.0;
}

}  // namespace

double history_coordinate(double travel, double unit_travel) {
  return std::copysign(std::log1p(std::abs(travel) / unit_travel), travel);
}

double travel_of_history(double coordinate, double unit_travel) {
  return std::copysign(std::expm1(std::abs(coordinate)) * unit_travel, coordinate);
}

std::vector<MotionSignal> motion_signals(const Identification& id, const Thresholds& limits) {
  std::vector<MotionSignal> out;
  const Model& arm = *id.model;
  const auto add = [&](SignalKind kind, std::optional<int> joint, bool slides, double unit_travel) {
    MotionSignal s{kind, joint, letter(kind), unit_of(kind, slides), numerics::kHuge,
                   -numerics::kHuge, unit_travel};
    if (joint) s.name += std::to_string(*joint + 1);
    const double rest = joint ? rest_speed_of(id, *joint) : 0.0;
    for (const RecordingError& r : id.train) {
      for (const double v : along(s, r.series, rest)) {
        s.low = std::min(s.low, v);
        s.high = std::max(s.high, v);
      }
    }
    if (s.high > s.low) out.push_back(std::move(s));
  };
  for (int i = 0; i < arm.joints(); ++i) {
    const bool slides = arm.coordinates()[i].prismatic;
    add(SignalKind::kPosition, i, slides, 1.0);
    if (out.empty() || out.back().joint != i) continue;
    const double travel = out.back().high - out.back().low;
    if (travel <= limits.still(slides)) {
      out.pop_back();
      continue;
    }
    add(SignalKind::kVelocity, i, slides, 1.0);
    add(SignalKind::kAcceleration, i, slides, 1.0);
    add(SignalKind::kTorque, i, slides, 1.0);
    add(SignalKind::kHistory, i, slides, travel * numerics::kHistoryUnit);
  }
  add(SignalKind::kTime, {}, false, 1.0);
  return out;
}

std::vector<int> folds_of(const MotionRows& rows, const Thresholds& limits) {
  if (rows.recordings == 0) return {};
  const HoldOut how = hold_out(limits);
  const size_t parts = how.parts_of_each(rows.recordings);
  const size_t most = 2 * how.parts_of_each(1);
  std::vector<int> out;
  for (size_t r = 0; r < rows.phase.size(); ++r) {
    const size_t part = std::min(static_cast<size_t>(rows.phase[r] * static_cast<double>(parts)), parts - 1);
    out.push_back(static_cast<int>((rows.recording[r] * parts + part) % most));
  }
  return out;
}

MotionRows motion_rows(const Identification& id, const std::vector<RecordingError>& recordings,
                       const std::vector<ExcludedInterval>& excluded_intervals, std::vector<MotionSignal> signals) {
  MotionRows out;
  out.signals = std::move(signals);
  out.recordings = recordings.size();
  const int n = id.model->joints();
  const size_t most = std::max(numerics::kFewestMotionRows, numerics::kMostMotionRows / std::max<size_t>(1, recordings.size()));
  std::vector<size_t> strides;
  Eigen::Index rows = 0;
  for (const RecordingError& r : recordings) {
    const size_t samples = r.series.time.size();
    strides.push_back(std::max<size_t>(1, (samples + most - 1) / most));
    const double rate = samples > 1 ? static_cast<double>(samples - 1) /
                                          (r.series.time.back() - r.series.time.front())
                                    : 0.0;
    const double enough = numerics::kRowsPerCutoff * id.preprocessing.cutoff;
    if (enough > 0.0)
      strides.back() = std::max(strides.back(), static_cast<size_t>(std::max(1.0, rate / enough)));
    rows += static_cast<Eigen::Index>((samples + strides.back() - 1) / strides.back());
  }
  out.values.resize(rows, static_cast<Eigen::Index>(out.signals.size()));
  out.residual.resize(rows, n);
  out.measured.resize(rows, n);
  out.used.setConstant(rows, n, true);
  Eigen::Index first = 0;
  for (size_t k = 0; k < recordings.size(); ++k) {
    const RecordingError& r = recordings[k];
    const PredictionSeries& x = r.series;
    Eigen::Index row = first;
    for (size_t s = 0; s < out.signals.size(); ++s) {
      const MotionSignal& signal = out.signals[s];
      const std::vector<double> all =
          along(signal, x, signal.joint ? rest_speed_of(id, *signal.joint) : 0.0);
      row = first;
      for (size_t i = 0; i < x.time.size(); i += strides[k])
        out.values(row++, static_cast<Eigen::Index>(s)) = all[i];
    }
    row = first;
    for (size_t i = 0; i < x.time.size(); i += strides[k], ++row) {
      for (int j = 0; j < n; ++j) {
        const auto at = static_cast<size_t>(j);
        out.measured(row, j) = x.measured[at][i];
        out.residual(row, j) = x.measured[at][i] - x.modelled[at][i];
      }
      out.recording.push_back(k);
      out.phase.push_back(phase_of(r, x.time[i]));
      for (const ExcludedInterval& part : excluded_intervals) {
        if (part.source != r.source || x.time[i] < part.from || x.time[i] > part.to) continue;
        for (int j = 0; j < n; ++j) {
          if (!part.joint || part.joint == j) out.used(row, j) = false;
        }
      }
    }
    first = row;
  }
  return out;
}

}  // namespace veridyn
