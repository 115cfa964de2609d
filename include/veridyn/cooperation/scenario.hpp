#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "veridyn/control/force_law.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/simulation/force_sensor.hpp"

namespace veridyn {

/// Who follows what: a position loop follows the motion, an impedance gives way to forces.
enum class ArmControl { kPosition, kImpedance };

/// One arm of a scenario.
struct ScenarioArm {
  std::string name;
  std::string model;  ///< robot file or MODEL, see read_model(); without values: plausible ones
  unsigned seed = 1;  ///< of plausible values
  Eigen::Vector3d position{0.0, 0.0, 0.0};  ///< [m] of the base in the world
  Eigen::Vector3d turn{0.0, 0.0, 0.0};      ///< [rad]: R_world_base = Rz(c) Ry(b) Rx(a)
  std::string frame;                        ///< that holds the object
  Eigen::Vector3d offset{0.0, 0.0, 0.0};    ///< [m] of the point in the frame
  VectorXd start;                           ///< (n) joints at the start
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
};

struct ScenarioFault {
  enum class Kind { kArmLimp, kArmFrozen, kSensorStuck, kSensorStale };
  Kind kind = Kind::kArmLimp;
  int arm = -1, member = -1;
  double at = 0.0;        ///< [s]
  bool reported = false;  ///< the arm tells the controller that it is lost
};

/// Settings of the loops.
struct ScenarioControl {
  double rate = 1000.0;                 ///< [Hz]
  double position_frequency = 15.0;     ///< [Hz] bandwidth of position loops, critically damped
  Eigen::Vector3d mass{0.3, 0.3, 0.3};  ///< of impedances, in the arm's base [kg]
  Eigen::Vector3d damping{30.0, 30.0, 30.0};       ///< [N s/m]
  Eigen::Vector3d stiffness{300.0, 300.0, 300.0};  ///< [N/m]
  double friction = 0.5;              ///< share of the friction known that is compensated
  double observer = 5.0;              ///< [Hz] of the observer of model errors; 0: none
  double velocity_cutoff = 400.0;     ///< [Hz] of the velocities from encoders
  double largest_force = 20.0;        ///< [N] at which the task ends
  double largest_force_error = 20.0;  ///< [N] likewise, of a reading from h_d
  double largest_error = 0.02;        ///< [m] likewise
  double largest_age = 0.02;          ///< [s] likewise
  double stuck_force = 1.0;           ///< [N] see CooperativeOptions
};

/// A grid of runs; empty lists keep the scenario's own value.
struct ScenarioSweep {
  std::vector<double> stiffness, delay, rate;  ///< [N/m], [s], [Hz] of the control loop
  double stable_error = 0.0;  ///< [N] steady error and oscillation up to which a run is stable
};

/// An experiment with arms that hold an object.
struct Scenario {
  std::string name, source;
  unsigned seed = 1;             ///< of noise and of model errors
  double model_error = 0.0;      ///< share by which all parameters known to controllers are wrong
  std::string encoder = "dvrk";  ///< preset of sensor_noise() whose encoder steps are used
  std::vector<ScenarioArm> arms;
  int master = 0;
  std::vector<ScenarioMember> members;
  ScenarioControl control;
  std::vector<ScenarioPhase> phases;
  std::vector<ScenarioFault> faults;
  ScenarioSweep sweep;
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
