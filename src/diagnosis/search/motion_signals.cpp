#include "diagnosis/search/motion_signals.hpp"

#include <algorithm>

#include "diagnosis/numerics.hpp"

namespace veridyn {
namespace {

// Extends the range of a signal to all its values.
void widen(const std::vector<double>& values, MotionSignal& s) {
  for (const double v : values) {
    s.low = std::min(s.low, v);
    s.high = std::max(s.high, v);
  }
}

}  // namespace

std::vector<MotionSignal> motion_signals(const Identification& id, const Thresholds& limits) {
  std::vector<MotionSignal> out;
  const auto add = [&](SignalKind kind, std::optional<int> joint, const char* letter, std::string unit, const auto& series) {
    MotionSignal s{kind, joint, letter, std::move(unit), numerics::kHuge, -numerics::kHuge};
    if (joint) s.name += std::to_string(*joint + 1);
    for (const RecordingError& r : id.train) widen(series(r.series), s);
    if (s.high > s.low) out.push_back(std::move(s));
  };
  for (int i = 0; i < id.model->joints(); ++i) {
    const Coordinate& joint = id.model->coordinates()[i];
    const std::string length = joint.prismatic ? "m" : "rad";
    add(SignalKind::kPosition, i, "q", length, [i](const PredictionSeries& x) { return x.q[i]; });
    if (out.empty() || out.back().joint != i) continue;
    const double travel = out.back().high - out.back().low;
    if (travel <= limits.still(joint.prismatic)) {
      out.pop_back();
      continue;
    }
    add(SignalKind::kVelocity, i, "dq", length + "/s", [i](const PredictionSeries& x) { return x.dq[i]; });
    add(SignalKind::kTorque, i, "tau", effort_unit(joint), [i](const PredictionSeries& x) { return x.modelled[i]; });
    out.push_back({SignalKind::kHistory, i, "history" + std::to_string(i + 1), length, -travel, travel});
  }
  add(SignalKind::kTime, {}, "t", "s", [](const PredictionSeries& x) { return x.time; });
  return out;
}

}  // namespace veridyn
