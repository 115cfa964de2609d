#pragma once

#include <vector>

#include "veridyn/math/motion_samples.hpp"
#include "veridyn/model/model.hpp"
#include "veridyn/simulation/hidden_effect.hpp"
#include "veridyn/simulation/sensor_noise.hpp"

namespace veridyn {

struct SimulationOptions {
  std::vector<HiddenEffect> hidden;
  SensorNoise noise;  ///< default: ideal
  unsigned seed = 1;  ///< seed of the noise
  int substeps = 4;   ///< states per row at which effects with memory are evaluated
};

/// True signals of a simulated arm and their recording.
struct SimulatedRecording {
  Model truth;                         ///< the arm with its physical hidden effects
  std::vector<InjectedEffect> injected;  ///< hidden effects with all numbers
  MotionSamples actual;                ///< the true motion
  MatrixXd actual_tau;                 ///< (rows x n) the true motor torques [N m], [N]
  MotionSamples measured;              ///< q and dq as recorded; ddq is the true one
  MatrixXd tau;                        ///< (rows x n) recorded torques [N m], [N]
};

/// Moves an arm with values along a prescribed motion and records it.
///
///   tau = M ddq + C dq + g + effects
///
/// at the actual motion, the wanted one plus the tracking deviation. Effects act on the actual
/// motion; the recording contains offset and steps of the encoders, noise, gain and delay of the
/// torques, and stale rows.
///
/// @param wanted  rows in order of time, with velocities and accelerations consistent with the
/// positions.
/// @throws InvalidInput  wanted does not fit the arm or its time does not increase; a body has no
/// values; as inject_effects().
SimulatedRecording simulate_recording(const Model& arm, const MotionSamples& wanted,
                                      const SimulationOptions& options = {});

/// Completes a motion through positions at the times of `given`: empty dq or ddq are derivatives of
/// fourth order.
/// @throws InvalidInput  fewer than five rows, or times that are not evenly spaced though a
/// derivative is missing.
MotionSamples with_derivatives(const MotionSamples& given);

}  // namespace veridyn
