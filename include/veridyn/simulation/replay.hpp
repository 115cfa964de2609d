#pragma once

#include <string>
#include <vector>

#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/recordings/recording_quality.hpp"
#include "veridyn/simulation/control_loop.hpp"

namespace veridyn {

/// A recording to drive a model with, on a uniform grid.
struct ReplayInput {
  MotionSamples motion;   ///< as recorded, lightly low-passed
  MatrixXd tau;           ///< (rows x n) as recorded
  std::vector<char> use;  ///< (rows) 0: in a gap or at an edge, left out of the errors
  RecordingQuality quality{};           ///< Quality of the recording
  std::vector<std::string> remarks{};   ///< velocities taken from positions, rows that were filled in
};

/// The recording on its uniform grid, lightly low-passed, as identification sees it. A recorded
/// velocity that is wrong in scale, late or coarser than its position's derivative is taken from the
/// position.
/// @throws InvalidInput  as for_each_stretch().
ReplayInput replay_input(const Model& arm, const std::string& recording, PreprocessingOptions how);

/// What of the recording is given to the model, and what is compared.
enum class ReplayDrive {
  /// The set points that the recorded controller must have had lead a PID: those for which
  /// tau = p e + d de/dt gives the recorded torque at the recorded motion (gains.i is not used).
  kCommands,
  kSetPoints,  ///< the recorded motion leads a PID: the torques that the model needs
  kTorques     ///< the recorded torques act: the motion that the model makes of them
};

struct ReplayOptions {
  ReplayDrive drive = ReplayDrive::kCommands;
  LoopOptions loop;  ///< for set points; empty gains: sensible_gains() of the arm
  /// [Hz] zero-phase low-pass of the motion and the torques that make set points; 0: none.
  double set_point_cutoff = 0.0;
  double cutoff = 5.0;  ///< [Hz] zero-phase low-pass of both torques before they are compared
  int order = 6;
};

/// Simulated against recorded, over the rows in use. (n) each.
struct Replay {
  EngineRun run;
  PidGains gains;
  VectorXd torque_error;   ///< || tau_sim - tau || / || tau ||, both low-passed; drive: set points
  VectorXd inverse_error;  ///< the same for the model's torques at the recorded motion: its
                           ///< prediction error, without any simulation
  VectorXd motion_rms;     ///< [rad], [m] of q_sim - q
  VectorXd motion_max;
  /// Low-passed, (rows x n): what was recorded, what the run gave, and what the model alone asks
  /// for at the recorded motion.
  MatrixXd recorded_tau, simulated_tau, predicted_tau;
  std::vector<char> use;  ///< (rows) of the run: 0 is left out of the errors
};

/// Drives the engine of this arm with a recording, from its first row on.
///
/// What leads is slow as the recorded position and fast as the integral of the recorded velocity
/// (they meet at 0.5 Hz), and its velocity is its own derivative: rows that came milliseconds late
/// would act through the damping as torques. Effects of measured motion (transmission_compliance)
/// are added to the simulated torque along the simulated motion.
/// @throws InvalidInput  sizes that do not fit; the run ends before its tenth row.
Replay replay(Engine& engine, const Model& arm, const ReplayInput& input,
              const ReplayOptions& options);

}  // namespace veridyn
