#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/math/types.hpp"
#include "veridyn/model/joint_sensors.hpp"

namespace veridyn {

/// An effect that a simulated arm has and its robot file does not, parsed from
/// NAME:PLACE[:KEY=VALUE,...].
///
/// PLACE is a coordinate's name or its number from 1, for effects that act along an axis. Their
/// keys are the parameters and shape constants of the effect, and `from=COORDINATE` for couplings.
/// The others:
///
///   payload:FRAME            mass [kg], x, y, z [m]: a point mass on a frame
///   gravity_tilt:arm         roll, pitch [rad]: the base is tilted, R = Ry(pitch) Rx(roll)
///   coupling_error:CONSTANT  change: added to a constant of the robot file
///   torque_gain:JOINT        gain: recorded torque per true torque
///   time_delay:JOINT         seconds: lag of the recorded torque
///   encoder_offset:JOINT     offset [rad] or [m]: added to the recorded position
///   external_contact:JOINT   from, to [s], effort [N m]: additional torque of the motor
///
/// Values may be arithmetic expressions. Missing values get defaults, see inject_effects().
struct HiddenEffect {
  std::string asked;  ///< original text, for messages
  std::string effect;
  std::string place;
  std::map<std::string, double> values;
  std::string from;  ///< second coordinate of a coupling; empty otherwise
};

/// @throws InvalidInput  another form, an unknown effect (with a suggestion), a repeated key, or a
/// value that is NaN or infinite.
HiddenEffect parse_hidden_effect(const std::string& asked);

/// A hidden effect with all its values.
struct InjectedEffect {
  std::string effect;
  std::string place;  ///< name of the coordinate, frame or constant; "arm"
  std::optional<JointIndex> joint;  ///< nullopt: it belongs to no single joint
  std::map<std::string, double> values;
};

/// An arm with its hidden effects: physical ones are part of the model, errors of sensors are
/// separate.
struct PerturbedArm {
  Model arm;
  std::vector<InjectedEffect> effects;
  /// Sensor errors of the simulated arm; the model keeps those that its file knows.
  JointSensors sensors;
  struct Contact {
    JointIndex joint;
    double from, to, effort;
  };
  std::vector<Contact> contacts;
};

/// Adds effects to an arm with values.
///
/// Defaults: the parameters of an effect along an axis together make 10 % of the rms effort along
/// it, over a standard motion that depends on the arm alone (slow waves of all joints), so that
/// every recording of an arm has the same effect; shape constants have the effect's initial values,
/// `centre` and `half_range` come from the joint's limits. payload 10 % of the mean body mass, at
/// the frame's origin; gain 1.05; delay 4 ms; offset 0.01 rad or 1 mm; tilt 30 and 20 mrad; contact
/// half of the rms effort from 5 to 7 s; a constant changes by 10 %, a zero one by 0.05.
/// @throws InvalidInput  no such coordinate, frame, constant or key (with a suggestion), or a value
/// out of range.
PerturbedArm inject_effects(const Model& arm, const std::vector<HiddenEffect>& hidden);

}  // namespace veridyn
