#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/dvrk/config/io_config.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn::dvrk {

/// One joint, for kinematics and users.
struct ArmJoint {
  std::string name;
  bool prismatic = false;
  std::optional<DhRow> dh;  ///< nullopt: the joint moves no frame (the jaw)
  double lower = 0.0;       ///< [rad] or [m]
  double upper = 0.0;
  double velocity = 0.0;  ///< largest velocity [rad/s] or [m/s]; 0: unknown
};

/// One motor with its gear, encoder and pot, before calibration.
struct ArmActuator {
  std::string name;
  bool prismatic = false;
  int board = 0;  ///< 0 or 1: first or second of the arm's boards
  int axis = 0;
  double direction = 1.0;        ///< 1, or -1 if the encoder is mounted reversed
  double counts = 0.0;           ///< Encoder counts per turn of the motor
  double gear = 0.0;  ///< turns of the motor per turn of the actuator; [rad/m] if prismatic
  double torque_constant = 0.0;  ///< Torque constant of the motor [N m/A]
  double max_current = 0.0;      ///< [A] largest current of the motor
  double lower = 0.0;            ///< soft limits [rad] or [m]
  double upper = 0.0;
  double kp = 0.0;  ///< Proportional gain of the dVRK software's PID [N m/rad] or [N/m]
  double kd = 0.0;
  LinearScale pot;  ///< [rad/V, rad] or [m/V, m]
  std::optional<BrakeConfig> brake;

  /// direction * 2 pi / (counts gear) [rad] or [m] per count.
  double bits_to_position() const;
  /// 1 / (gear torque_constant) [A/N m] or [A/N].
  double effort_to_amps() const { return 1.0 / (gear * torque_constant); }
};

/// An instrument couples the actuators from `first` on: joints = coupling * actuators.
struct ArmInstrument {
  std::string name;
  int first = 0;
  MatrixXd coupling;
};

/// Facts common to all arms of a kind, and the sockets of this one.
struct ArmFacts {
  std::string name;                 ///< "PSM1"
  std::string kind;                 ///< "PSM"
  std::vector<int> boards;          ///< usual board ids
  std::vector<std::string> unsure;  ///< unverified facts of the file
  std::vector<ArmJoint> joints;
  std::vector<ArmActuator> actuators;
  MatrixXd actuator_to_joint;  ///< without an instrument
  MatrixXd pots_to_actuators;  ///< empty: pots sit on the actuators
  std::vector<ArmInstrument> instruments;
  Eigen::Isometry3d T_last_tip = Eigen::Isometry3d::Identity();  ///< T from the frame of the last DH row to the tip

  /// K with an instrument; without one if the name is empty.
  /// @throws InvalidInput  the arm knows no such instrument.
  MatrixXd coupling(const std::string& instrument = "") const;

  /// Joints that have a DH row, first to last.
  int kinematic_joints() const;
};

/// The arm of that name ("PSM1", "MTMR", "ECM"), from data/dvrk or $VERIDYN_DVRK; or from a file,
/// if the name is "FILE.yaml:NAME".
/// @throws InvalidInput  there is no such arm, or its file is wrong: file, line, found, expected; its
/// nominal_config() is invalid (check_io_config(): two motors on one channel).
ArmFacts read_arm(const std::string& name);

/// Names that read_arm() knows.
std::vector<std::string> arm_names();

/// The chain of DH rows with a frame "tip" at its end, without bodies, for the library's generic
/// functions. @throws InvalidInput  no joint has a DH row.
Model arm_model(const ArmFacts& arm);

/// A configuration of nominal scales, as of an uncalibrated arm; pots without a known scale cover the
/// actuator's range.
IoConfig nominal_config(const ArmFacts& arm);

}  // namespace veridyn::dvrk
