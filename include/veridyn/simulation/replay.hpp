#pragma once

#include <string>
#include <vector>

#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/recordings/recording_quality.hpp"
#include "veridyn/simulation/control_loop.hpp"

namespace veridyn {

/// A recording on a uniform grid that drives a model.
struct ReplayInput {
  MotionSamples motion;   ///< recorded motion, lightly low-passed
  MatrixXd tau;           ///< (rows x n) recorded torques [N m], [N]
  std::vector<char> use;  ///< (rows) 0: in a gap or at an edge, excluded from the errors
  RecordingQuality quality{};           ///< quality of the recording
  /// Remarks on velocities derived from positions, and on rows that were interpolated.
  std::vector<std::string> remarks{};
};

/// The recording on its uniform grid, lightly low-passed, as in identification. A recorded velocity
/// that is wrong in scale, late or coarser than its position's derivative is replaced by that
/// derivative.
/// @throws InvalidInput  as for_each_segment().
ReplayInput replay_input(const Model& arm, const std::string& recording, PreprocessingOptions how);

/// Inputs of the model and signals to compare.
enum class ReplayDrive {
  /// A PID follows the set points of the recorded controller, reconstructed such that tau = p e + d de/dt
  /// gives the recorded torque at the recorded motion (gains.i is not used).
  kCommands,
  kSetPoints,  ///< a PID follows the recorded motion; compares the torques
  kTorques     ///< the recorded torques are applied; compares the motion
};

struct ReplayOptions {
  ReplayDrive drive = ReplayDrive::kCommands;
  LoopOptions loop;  ///< loop of the PID; empty gains: sensible_gains() of the arm
  /// [Hz] zero-phase low-pass of the motion and the torques from which set points are computed; 0:
  /// none.
  double set_point_cutoff = 0.0;
  double cutoff = 5.0;  ///< [Hz] zero-phase low-pass of both torques before they are compared
  int order = 6;
};

/// Comparison of simulated with recorded signals, over the rows in use. (n) each.
struct Replay {
  EngineRun run;
  PidGains gains;
  VectorXd torque_error;   ///< || tau_sim - tau || / || tau ||, both low-passed; with a PID only
  /// The same error for inverse dynamics at the recorded motion: the model's prediction error without a
  /// simulation.
  VectorXd inverse_error;
  VectorXd motion_rms;     ///< root mean square of q_sim - q [rad], [m]
  VectorXd motion_max;
  /// Low-passed torques, (rows x n): recorded, of the run, and of inverse dynamics at the recorded
  /// motion.
  MatrixXd recorded_tau, simulated_tau, predicted_tau;
  std::vector<char> use;  ///< (rows) 0: the row is excluded from the errors
};

/// Drives the engine of this arm with a recording, from its first row on.
///
/// Below 0.5 Hz the reference is the recorded position, above it the integral of the recorded
/// velocity, and its velocity is its own derivative: jitter of milliseconds in the rows' times
/// would otherwise act through the damping as torques. Effects of measured motion
/// (transmission_compliance) are added to the simulated torque along the simulated motion.
/// @throws InvalidInput  sizes differ, or the run ends before its tenth row.
Replay replay(Engine& engine, const Model& arm, const ReplayInput& input,
              const ReplayOptions& options);

}  // namespace veridyn
