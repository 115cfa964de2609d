#pragma once

#include <string>
#include <vector>

#include "veridyn/math/motion_samples.hpp"
#include "veridyn/simulation/hidden_effect.hpp"
#include "veridyn/simulation/plant.hpp"

namespace veridyn {

/// tau = p e + i (integral of e) + d de/dt, per joint, with e the set point minus what the encoder
/// says. (n) each: [N m/rad], [N m/(rad s)], [N m s/rad]; newtons and metres where a joint is
/// prismatic.
struct PidGains {
  VectorXd p, i, d;
};

/// Gains that fit an arm with values: each joint alone, with the inertia that it has in the middle
/// of the range, gets a bandwidth of `frequency` [Hz] and critical damping, and an integral ten
/// times slower.
PidGains sensible_gains(const Model& arm, double frequency = 6.0);

/// Damping for given p: critical for the inertia in the middle of the range.
VectorXd critical_damping(const Model& arm, const VectorXd& p);

/// Reads `p: [..]`, `i: [..]`, `d: [..]` from a YAML file, a number per joint. i may be missing
/// (none), and d (critical damping).
/// @throws InvalidInput  the file is bad, or has another number of joints.
PidGains read_gains(const std::string& path, const Model& arm);

/// The motors and their amplifiers.
struct Drive {
  VectorXd limit;     ///< (n) largest torque [N m], [N]; empty: the robot file's effort limits
  double lag = 0.0;   ///< [s] time constant of the current loop
  double step = 0.0;  ///< torques are multiples of it [N m], [N]; 0: exact
};

/// What the controller sees.
struct LoopSensors {
  VectorXd encoder_step;  ///< (n) positions are multiples of it; empty: exact
  double delay = 0.0;     ///< [s] by which positions are late; whole periods of the controller
  double velocity_cutoff = 80.0;  ///< [Hz] low-pass of the differences of position; 0: none
};

struct LoopOptions {
  PidGains gains;
  Drive drive;
  LoopSensors sensors;
  /// [Hz] of the controller, whatever the rows' rate: between two rows it acts a whole number of
  /// times, or once in a whole number of rows, whichever comes closest.
  double rate = 1000.0;
  VectorXd start;  ///< (n) where the arm stands first; empty: at the first set point
  std::vector<PerturbedArm::Contact> contacts;  ///< what the world does to the arm
};

/// What an engine did, up to the row at which it ended or had to stop.
struct EngineRun {
  MotionSamples motion;
  MatrixXd tau;  ///< (rows x n) of the motors
  StepStatus status = StepStatus::kOk;
  double stopped_at = 0.0;  ///< [s] where status is not kOk
  int joint = -1;           ///< Joint that failed, from 0; -1: none in particular

  bool complete() const { return status == StepStatus::kOk; }
  /// "stopped at 1.2 s: joint insertion has ...", for a run that is not complete.
  std::string why(const Model& arm) const;
};

/// Lets a PID follow set points, from the first one on; rows are recorded at their times. Between
/// them set points run straight, with their velocities. Ends with kRanAway where a joint is more
/// than ten times its range off its set point.
/// @throws InvalidInput  sizes that do not fit, a rate or a lag that cannot be.
EngineRun run_with_pid(Engine& engine, const Model& arm, const MotionSamples& set_points,
                       const LoopOptions& options);

/// Lets recorded torques act: row k from its time on until that of row k + 1. Starts at the first
/// row of `motion`, whose times are used.
EngineRun run_with_torques(Engine& engine, const MotionSamples& motion, const MatrixRef& tau);

/// What a contact adds to the motor's torque at time t [s] since the start: in full within its
/// time, with ramps of 0.1 s.
double contact_effort(const PerturbedArm::Contact& contact, double t);

}  // namespace veridyn
