#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/control/computed_torque.hpp"
#include "veridyn/control/impedance.hpp"
#include "veridyn/control/joint_pid.hpp"
#include "veridyn/math/motion_samples.hpp"
#include "veridyn/simulation/hidden_effect.hpp"
#include "veridyn/simulation/plant.hpp"

namespace veridyn {

/// Gains for an arm with values: each joint by itself, with its inertia at the middle of the range,
/// gets a bandwidth of `frequency` [Hz], critical damping, and an integral term ten times slower.
PidGains sensible_gains(const Model& arm, double frequency = 6.0);

/// Gains d [N m s/rad], [N s/m] for given p: critical damping of each joint with its inertia in the middle of the range.
VectorXd critical_damping(const Model& arm, const VectorRef& p);

/// Reads `p: [..]`, `i: [..]`, `d: [..]` from a YAML file, one number per joint. The default of i is zero,
/// that of d critical damping.
/// @throws InvalidInput  the file is malformed, or its number of joints differs.
PidGains read_gains(const std::string& path, const Model& arm);

/// Reads `p` [1/s^2] and `d` [1/s] of computed torque in the same way; without d critical damping, 2 sqrt(p).
JointGains read_joint_gains(const std::string& path, const Model& arm);

/// Reads `mass` [kg], `damping` [N s/m] and `stiffness` [N/m] of an impedance of the tip's position in the same
/// way, three numbers each.
ImpedanceGains read_tip_gains(const std::string& path);

/// The motors and their amplifiers.
struct Drive {
  VectorXd limit;     ///< (n) largest torque [N m], [N]; empty: the robot file's effort limits
  double lag = 0.0;   ///< [s] time constant of the current loop
  double step = 0.0;  ///< [N m], [N] torques are multiples of this; 0: exact
};

/// Sensors of the controller.
struct LoopSensors {
  VectorXd encoder_step;  ///< (n) positions are multiples of it; empty: exact
  double delay = 0.0;     ///< [s] delay of the positions, in whole periods of the controller
  double velocity_cutoff = 80.0;  ///< [Hz] low-pass of the differentiated positions; 0: none
};

struct LoopOptions {
  PidGains gains;
  /// If not null, computed torque with this model replaces the PID. `gains` are then those of ComputedTorque, p
  /// [1/s^2] and d [1/s], independent of the joints' inertia, and i is not used.
  std::shared_ptr<const Model> model;
  double friction = 0.0;  ///< share of the model's friction that is compensated in addition to that law
  Drive drive;
  LoopSensors sensors;
  /// Rate of the controller [Hz], independent of the rows' rate: it runs an integer number of times between two
  /// rows, or once in an integer number of rows, whichever is closest.
  double rate = 1000.0;
  VectorXd start;  ///< (n) initial position; empty: the first set point
  std::vector<PerturbedArm::Contact> contacts;  ///< external forces on the arm
};

/// Result of an engine's run, up to its last or its failing row.
struct EngineRun {
  MotionSamples motion;
  MatrixXd tau;  ///< (rows x n) motor torques [N m], [N]
  StepStatus status = StepStatus::kOk;
  double stopped_at = 0.0;  ///< [s] time of the failure if status is not kOk
  std::optional<JointIndex> joint = {};  ///< joint that failed

  bool complete() const { return status == StepStatus::kOk; }
  /// Text "stopped at 1.2 s: joint insertion has ...", for a run that is incomplete.
  std::string stop_reason(const Model& arm) const;
};

/// Runs a PID, or computed torque, along set points from the first one on; rows are recorded at their times.
/// Set points between rows are interpolated linearly, with their velocities. Ends with kRanAway if a joint is
/// farther from its set point than ten times its range.
/// @throws InvalidInput  sizes differ, or a rate or a lag is out of range.
EngineRun run_with_pid(Engine& engine, const Model& arm, const MotionSamples& set_points,
                       const LoopOptions& options);

/// Steps of one joint after the other from rest to rest, as in figure 7.3 of the thesis: quintic, 1 s each,
/// followed by 2 s of rest; rows at 1 kHz. @param start, steps  (n) [rad], [m].
MotionSamples joint_steps(const VectorRef& start, const VectorRef& steps);

/// Applies recorded torques: row k from its time until that of row k + 1. Starts at the first row
/// of `motion`, whose times are used. @throws InvalidInput  sizes differ, or fewer than two rows.
EngineRun run_with_torques(Engine& engine, const MotionSamples& motion, const MatrixRef& tau);

/// Effort of a contact in addition to the motor's torque at time t [s] since the start: the full
/// value within its interval, with ramps of 0.1 s.
double contact_effort(const PerturbedArm::Contact& contact, double t);

}  // namespace veridyn
