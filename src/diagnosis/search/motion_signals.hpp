#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Signals on which a residual may depend.
enum class SignalKind { kPosition, kVelocity, kTorque, kHistory, kTime };

/// One signal of a recorded motion. Model torque is the model's prediction; a history is the signed
/// travel since the last reversal.
struct MotionSignal {
  SignalKind kind = SignalKind::kPosition;
  std::optional<int> joint = {};  ///< nothing: time
  std::string name;  ///< "q1", "dq1", "tau1", "history1", "t"
  std::string unit;
  double low = 0.0, high = 0.0;  ///< range in the training recordings
};

/// The signals of the joints that move, from the series of an identification.
std::vector<MotionSignal> motion_signals(const Identification& id, const Thresholds& limits);

}  // namespace veridyn
