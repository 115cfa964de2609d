#pragma once

#include <cmath>
#include <string>

#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/simulate_recording.hpp"

namespace veridyn {

/// Waves of all joints, with their exact derivatives; 10 s at 200 Hz.
inline MotionSamples waves(int joints, double size = 0.1) {
  const Eigen::Index rows = 2001;
  MotionSamples m{VectorXd::LinSpaced(rows, 0.0, 10.0), MatrixXd(rows, joints),
                  MatrixXd(rows, joints), MatrixXd(rows, joints)};
  for (Eigen::Index i = 0; i < joints; ++i) {
    const double w = 2.0 + 0.7 * static_cast<double>(i);
    const Eigen::ArrayXd angle = w * m.time.array() + 0.3 * static_cast<double>(i);
    m.q.col(i) = size * (1.1 + angle.sin());
    m.dq.col(i) = size * w * angle.cos();
    m.ddq.col(i) = -size * w * w * angle.sin();
  }
  return m;
}

/// An ideal recording with these hidden effects.
inline SimulatedRecording simulated(const Model& arm, const std::vector<std::string>& effects,
                                    const SensorNoise& noise = {}) {
  SimulationOptions options;
  for (const std::string& asked : effects) options.hidden.push_back(parse_hidden_effect(asked));
  options.noise = noise;
  return simulate_recording(arm, waves(arm.joints()), options);
}

}  // namespace veridyn
