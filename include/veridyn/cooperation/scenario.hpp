#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "veridyn/control/force_law.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/simulation/force_sensor.hpp"

namespace veridyn {

/// Who follows what: a position loop follows the motion, an impedance gives way to forces.
enum class ArmControl { kPosition, kImpedance };

/// One arm of a scenario.
struct ScenarioArm {
  std::string name;
  std::string model;  ///< robot file or MODEL, see read_model(); without values: plausible ones
  unsigned seed = 1;  ///< Seed of plausible values
  Eigen::Vector3d position{0.0, 0.0, 0.0};  ///< [m] of the base in the world
  Eigen::Vector3d turn{0.0, 0.0, 0.0};      ///< [rad]: R_world_base = Rz(c) Ry(b) Rx(a)
  std::string frame;                        ///< The frame that holds the object
  Eigen::Vector3d offset{0.0, 0.0, 0.0};    ///< [m] of the point in the frame
  VectorXd start;                           ///< (n) joints at the start
  /// Where the controller's world believes the base: beside the true place by this way [m], and
  /// turned by Rz(c) Ry(b) Rx(a) [rad] on top of the true turn. A calibration's error.
  Eigen::Vector3d calibration_position{0.0, 0.0, 0.0};
  Eigen::Vector3d calibration_turn{0.0, 0.0, 0.0};
  /// What the controller takes the arm for, geometry included; empty: the arm's own model.
  std::string controller_model;
  ArmControl control = ArmControl::kImpedance;
};

/// A member of the object between two arms, its force sensor, and how its force is controlled.
struct ScenarioMember {
  std::string name;
  int from = 0, to = 1;
  double stiffness = 0.0;  ///< [N/m]
  double damping = 0.0;    ///< [N s/m]
  bool pulls_only = false;
  double slack = 0.0;  ///< [m] by which it is longer than the distance of the arms at the start
  ForceSensorOptions sensor;
  ForceLaw law;
  bool tuned = false;  ///< the law is tuned_force_law() of this member and the slaves' impedance
};

/// A plane that an arm's tip can touch, with a force sensor between them.
struct ScenarioWall {
  std::string name;
  int arm = 0;
  Eigen::Vector3d point{0.0, 0.0, 0.0};   ///< [m] of the plane, from where the tip starts
  Eigen::Vector3d normal{0.0, 0.0, 1.0};  ///< out of the wall, of length one
  double stiffness = 0.0;                 ///< [N/m]
  double damping = 0.0;                   ///< [N s/m]: Kelvin and Voigt's law, as tissue has it
  ForceSensorOptions sensor;
};

/// A rigid body that arms hold by compliant grasps at their tips.
struct ScenarioBody {
  struct Grasp {
    int arm = 0;
    double stiffness = 0.0;  ///< [N/m] in all directions
    double damping = 0.0;    ///< [N s/m]
  };
  std::string name;
  double mass = 0.0;                       ///< [kg]
  Eigen::Vector3d inertia{0.0, 0.0, 0.0};  ///< [kg m^2] about its axes, which are the world's
  std::vector<Grasp> grasps;               ///< its centre is in the middle of them
  /// Its own impedance by ObjectImpedance, in all directions; stiffness 0: none, and arms hold it
  /// each by its own loop.
  double wanted_mass = 1.0, impedance_damping = 0.0, impedance_stiffness = 0.0;
  double wanted_inertia = 0.01, angular_damping = 0.0, angular_stiffness = 0.0;
  double internal_force = 0.0;  ///< [N] between the first two hands, pulling positive
};

/// One command of a phase; they begin with it.
struct ScenarioCommand {
  enum class Kind { kMove, kTurn, kTighten, kForce, kMoveArm, kRelease, kTake };
  Kind kind = Kind::kMove;
  Eigen::Vector3d way{0.0, 0.0, 0.0};  ///< [m] or [rad]
  double amount = 0.0;                 ///< [m] or [N]
  int arm = -1, member = -1;
  double over = 0.0;  ///< [s]
};

struct ScenarioPhase {
  std::string name;
  double duration = 0.0;  ///< [s]
  std::vector<ScenarioCommand> commands;
  double asked_force_error = 0.0;   ///< [N] largest allowed anywhere in the phase; 0: none asked
  double asked_steady_error = 0.0;  ///< [N] likewise in its last fifth
  double asked_position_error = 0.0;  ///< [m] of the master's tip and of held bodies; 0: none asked
};

struct ScenarioFault {
  enum class Kind { kArmLimp, kArmFrozen, kSensorStuck, kSensorStale, kSensorJump, kSensorDrift };
  Kind kind = Kind::kArmLimp;
  int arm = -1, member = -1;
  double at = 0.0;        ///< [s]
  double by = 0.0;        ///< [N] of kSensorJump, [N/s] of kSensorDrift
  bool reported = false;  ///< the arm tells the controller that it is lost
};

/// Settings of the loops.
struct ScenarioControl {
  double rate = 1000.0;                 ///< [Hz]
  double position_frequency = 15.0;     ///< [Hz] bandwidth of position loops, critically damped
  Eigen::Vector3d mass{0.3, 0.3, 0.3};  ///< Mass of impedances, in the arm's base [kg]
  Eigen::Vector3d damping{30.0, 30.0, 30.0};       ///< [N s/m]
  Eigen::Vector3d stiffness{300.0, 300.0, 300.0};  ///< [N/m]
  double friction = 0.5;              ///< share of the friction known that is compensated
  double observer = 5.0;              ///< [Hz] of the observer of model errors; 0: none
  FrictionRule friction_rule = FrictionRule::kPresliding;
  bool adaptive_friction = false;     ///< scale it while arms move, see AdaptiveFriction
  double velocity_cutoff = 400.0;     ///< [Hz] of the velocities from encoders
  double force_cutoff = 0.0;          ///< [Hz] of a low-pass of all force readings; 0: none
  double motor_lag = 0.0;             ///< [s] first-order lag between torques asked and made
  int torque_delay = 0;               ///< [cycles] that torques come later, beyond the cycle itself
  double largest_force = 20.0;        ///< [N] at which the task ends
  double largest_force_error = 20.0;  ///< [N] likewise, of a reading from h_d
  double largest_error = 0.02;        ///< [m] likewise
  double largest_age = 0.02;          ///< [s] likewise
  double stuck_force = 1.0;           ///< [N] see CooperativeOptions
  double jump_force = 1.0;            ///< [N] likewise
  double drift_force = 0.5;           ///< [N] likewise
  double largest_energy = 0.0;        ///< [J] that a member may get; 0: no bound
  double relief_force = 5.0;          ///< [N] to which arms give way while all is held
  bool guard = true;                  ///< arms give way where a force leaves its bounds
};

/// A grid of runs; empty lists keep the scenario's own value.
struct ScenarioSweep {
  std::vector<double> stiffness, delay, rate;  ///< [N/m], [s], [Hz] of the control loop
  double stable_error = 0.0;  ///< [N] steady error and oscillation up to which a run is stable
};

/// An experiment with arms that hold an object.
struct Scenario {
  std::string name, source;
  unsigned seed = 1;             ///< Seed of noise and of model errors
  double model_error = 0.0;      ///< share by which all parameters known to controllers are wrong
  std::string encoder = "dvrk";  ///< preset of sensor_noise() whose encoder steps are used
  std::vector<ScenarioArm> arms;
  int master = 0;
  std::vector<ScenarioMember> members;
  std::vector<ScenarioWall> walls;
  std::vector<ScenarioBody> bodies;
  ScenarioControl control;
  std::vector<ScenarioPhase> phases;
  std::vector<ScenarioFault> faults;
  ScenarioSweep sweep;
  double asked_largest_force = 0.0;  ///< [N] of any member at any time, faults included; 0: none
};

/// Reads a scenario file (YAML).
/// @throws InvalidInput  "file:line:column: found ..., expected ...".
Scenario read_scenario(const std::string& path);

/// Gives members with a tuned law the one for their stiffness.
void tune_force_laws(Scenario& scenario);

/// The same from text; `path` is for messages, and models named by relative paths are sought beside
/// it.
Scenario parse_scenario(const std::string& content, const std::string& path);

}  // namespace veridyn
