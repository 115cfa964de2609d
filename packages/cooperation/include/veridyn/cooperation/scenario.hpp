#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/control/force_law.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/simulation/force_sensor.hpp"

namespace veridyn {

/// Control of an arm: a position loop that follows the motion, or an impedance that yields to forces.
enum class ArmControl { kPosition, kImpedance };

/// One arm of a scenario.
struct ScenarioArm {
  std::string name;
  std::string model;  ///< robot file or identified model, see read_model(); without values: plausible ones
  unsigned seed = 1;  ///< Seed of plausible values
  Eigen::Vector3d position{0.0, 0.0, 0.0};  ///< [m] position of the base in the world
  Eigen::Vector3d turn{0.0, 0.0, 0.0};      ///< [rad]: R_world_base = Rz(c) Ry(b) Rx(a)
  std::string frame;                        ///< frame that holds the object
  Eigen::Vector3d offset{0.0, 0.0, 0.0};    ///< [m] position of the grasp point in the frame
  VectorXd start;                           ///< (n) joints at the start
  /// Error of the calibration: the controller assumes the base displaced by this vector [m] and
  /// rotated by Rz(c) Ry(b) Rx(a) [rad] relative to the true base.
  Eigen::Vector3d calibration_position{0.0, 0.0, 0.0};
  Eigen::Vector3d calibration_turn{0.0, 0.0, 0.0};
  /// Model used by the controller, geometry included; empty: the arm's own model.
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
  double slack = 0.0;  ///< [m] length in addition to the distance of the arms at the start
  ForceSensorOptions sensor;
  ForceLaw law;
  bool tuned = false;  ///< use tuned_force_law() of this member and the followers' impedance
};

/// A plane that an arm's tip can touch, with a force sensor between them.
struct ScenarioWall {
  std::string name;
  int arm = 0;
  Eigen::Vector3d point{0.0, 0.0, 0.0};   ///< [m] point of the plane, relative to the tip's start
  Eigen::Vector3d normal{0.0, 0.0, 1.0};  ///< outward unit normal
  double stiffness = 0.0;                 ///< [N/m]
  double stiffening = 0.0;  ///< [N/m^2] increase of the stiffness with the depth, as of tissue
  double damping = 0.0;     ///< [N s/m] of a Kelvin-Voigt model, as of tissue
  double drag = 0.0;        ///< [N s/m] along the plane
  ForceSensorOptions sensor;
  /// Axes of the sensor: 1 measures along the normal, 3 along the axes of the arm's frame, whose
  /// orientation the controller knows from its encoders.
  int sensor_axes = 1;
};

/// A rigid body that arms hold by compliant grasps at their tips.
struct ScenarioBody {
  struct Grasp {
    int arm = 0;
    double stiffness = 0.0;  ///< [N/m] stiffness in all directions
    double damping = 0.0;    ///< [N s/m]
  };
  std::string name;
  double mass = 0.0;                       ///< [kg]
  Eigen::Vector3d inertia{0.0, 0.0, 0.0};  ///< [kg m^2] about its axes, which are the world's
  std::vector<Grasp> grasps;               ///< the centre of the body is their mean
  /// Impedance of the body by ObjectImpedance, in all directions; stiffness 0: none, and each arm
  /// has only its own loop.
  double wanted_mass = 1.0, impedance_damping = 0.0, impedance_stiffness = 0.0;
  double wanted_inertia = 0.01, angular_damping = 0.0, angular_stiffness = 0.0;
  double internal_force = 0.0;  ///< [N] force between the first two hands, pulling positive
};

/// One command of a phase, executed at its beginning.
struct ScenarioCommand {
  enum class Kind { kMove, kTurn, kTighten, kForce, kMoveArm, kRelease, kTake };
  Kind kind = Kind::kMove;
  Eigen::Vector3d way{0.0, 0.0, 0.0};  ///< displacement [m], or rotation [rad] of kTurn
  double amount = 0.0;                 ///< [m] of kTighten, [N] of kForce
  int arm = 0, member = 0;  ///< arm or member that it concerns
  double over = 0.0;  ///< [s] duration of the motion or change of force
};

struct ScenarioPhase {
  std::string name;
  double duration = 0.0;  ///< [s] duration of the phase
  std::vector<ScenarioCommand> commands;
  double asked_force_error = 0.0;   ///< [N] bound for the whole phase; 0: none
  double asked_steady_error = 0.0;  ///< [N] bound for its last fifth; 0: none
  double asked_position_error = 0.0;  ///< [m] bound for the leader's tip and held bodies; 0: none
};

struct ScenarioFault {
  enum class Kind { kArmLimp, kArmFrozen, kSensorStuck, kSensorStale, kSensorJump, kSensorDrift };
  Kind kind = Kind::kArmLimp;
  std::optional<int> arm = {}, member = {};  ///< the arm, or the member whose sensor fails; exactly one is set
  double at = 0.0;        ///< [s] time of the fault since the start
  double by = 0.0;        ///< [N] size of kSensorJump, [N/s] slope of kSensorDrift
  bool reported = false;  ///< the controller is informed of the failed arm
};

constexpr int kLongestTorqueDelay = 1000;  ///< [cycles] largest ScenarioControl::torque_delay

/// Settings of the control loops.
struct ScenarioControl {
  double rate = 1000.0;                 ///< [Hz] rate of the control loops
  double position_frequency = 15.0;     ///< [Hz] bandwidth of critically damped position loops
  Eigen::Vector3d mass{0.3, 0.3, 0.3};  ///< Mass of impedances, in the arm's base [kg]
  Eigen::Vector3d damping{30.0, 30.0, 30.0};       ///< [N s/m] damping of impedances, axes of the base
  Eigen::Vector3d stiffness{300.0, 300.0, 300.0};  ///< [N/m] stiffness of impedances, axes of the base
  double friction = 0.5;              ///< share of the identified friction that is compensated
  double observer = 5.0;              ///< [Hz] bandwidth of the observer of model errors; 0: none
  FrictionRule friction_rule = FrictionRule::kPresliding;
  bool adaptive_friction = false;     ///< scale the friction while arms move, see AdaptiveFriction
  double velocity_cutoff = 400.0;     ///< [Hz] cutoff of the velocities from encoders
  double force_cutoff = 0.0;          ///< [Hz] cutoff of a low-pass of all force readings; 0: none
  double motor_lag = 0.0;             ///< [s] first-order lag between commanded and actual torques
  int torque_delay = 0;               ///< [cycles] additional delay of the torques, at most kLongestTorqueDelay
  double largest_force = 20.0;        ///< [N] largest force, beyond which the task ends
  double largest_force_error = 20.0;  ///< [N] the same for the difference of a reading from h_d
  double largest_error = 0.02;        ///< [m] likewise
  double largest_age = 0.02;          ///< [s] likewise
  double stuck_force = 1.0;           ///< [N] see CooperativeOptions
  double jump_force = 1.0;            ///< [N] likewise
  double drift_force = 0.5;           ///< [N] likewise
  double largest_energy = 0.0;        ///< [J] largest energy of a member; 0: no bound
  double relief_force = 5.0;          ///< [N] force beyond which arms yield while targets are held
  bool guard = true;                  ///< arms yield if a force leaves its bounds while targets are held
};

/// A grid of runs; empty lists keep the scenario's own value.
struct ScenarioSweep {
  std::vector<double> stiffness, delay, rate;  ///< [N/m], [s], [Hz] of the control loop
  /// [N] bound of the steady error and the oscillation of a stable run
  double stable_error = 0.0;
};

/// An experiment with arms that hold an object.
struct Scenario {
  std::string name, source;
  unsigned seed = 1;             ///< Seed of noise and of model errors
  double model_error = 0.0;      ///< relative error of all parameters known to controllers
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
  /// [N] bound for all members at all times, faults included; 0: none
  double asked_largest_force = 0.0;
};

/// Reads a scenario file (YAML).
/// @throws InvalidInput  "file:line:column: found ..., expected ...".
Scenario read_scenario(const std::string& path);

/// Sets the force law of members with a tuned law from their stiffness.
void tune_force_laws(Scenario& scenario);

/// The same from text; `path` is for messages, and models with relative paths are searched for next to it.
Scenario parse_scenario(const std::string& content, const std::string& path);

}  // namespace veridyn
