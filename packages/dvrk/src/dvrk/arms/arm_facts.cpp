#include "dvrk/arms/arm_facts.hpp"

#include <cmath>
#include <limits>

#include "veridyn/math/eigen_pose.hpp"
#include "veridyn/model/suggestion.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

// Usual tolerance of dVRK configurations between pots and encoders.
constexpr double kPotTolerance = 5.0 * M_PI / 180.0;  // [rad]
constexpr double kPotToleranceLength = 0.005;         // [m] tolerance for a prismatic joint
constexpr double kPotLatency = 0.01;  // [s] time for which the tolerance may be exceeded

ActuatorConfig nominal_actuator(const ArmActuator& facts, const std::vector<int>& boards) {
  ActuatorConfig actuator;
  actuator.board = boards[facts.board];
  actuator.axis = facts.axis;
  actuator.prismatic = facts.prismatic;
  actuator.amps_to_bits = {facts.direction * kNominalAmpsToBits.scale, kNominalAmpsToBits.offset};
  actuator.bits_to_amps = {facts.direction * kNominalBitsToAmps.scale,
                           facts.direction * kNominalBitsToAmps.offset};
  actuator.effort_to_amps = facts.effort_to_amps();
  actuator.max_current = facts.max_current;
  actuator.bits_to_position = facts.bits_to_position();
  actuator.lower = facts.lower;
  actuator.upper = facts.upper;
  actuator.bits_to_volts = kNominalBitsToVolts;
  actuator.volts_to_position = facts.pot;
  actuator.brake = facts.brake;
  return actuator;
}

}  // namespace

double ArmActuator::bits_to_position() const {
  return direction * 2.0 * M_PI / (counts * gear);
}

MatrixXd ArmFacts::coupling(const std::string& instrument) const {
  if (instrument.empty()) return actuator_to_joint;
  std::vector<std::string> names;
  for (const ArmInstrument& known : instruments) {
    names.push_back(known.name);
    if (known.name != instrument) continue;
    MatrixXd K = actuator_to_joint;
    K.bottomRightCorner(known.coupling.rows(), known.coupling.cols()) = known.coupling;
    return K;
  }
  throw InvalidInput(text(name, ": found no instrument '", instrument, "'",
                          did_you_mean(instrument, names), ", expected ",
                          names.empty() ? "none" : "one of: " + listed(names), "."));
}

int ArmFacts::kinematic_joints() const {
  int n = 0;
  for (const ArmJoint& joint : joints) n += joint.dh ? 1 : 0;
  return n;
}

Model arm_model(const ArmFacts& arm) {
  ModelDescription description;
  description.name = arm.name;
  const int n = arm.kinematic_joints();
  require(n > 0, "arm '", arm.name, "': found no joint with a DH row, expected at least one.");
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const ArmJoint& joint : arm.joints) {
    if (!joint.dh) continue;
    const int k = static_cast<int>(description.frames.size());
    Coordinate coordinate;
    coordinate.name = joint.name;
    coordinate.limits = {joint.lower, joint.upper, joint.velocity > 0 ? joint.velocity : kInfinity,
                         kInfinity, kInfinity};
    coordinate.prismatic = joint.prismatic;
    description.coordinates.push_back(coordinate);
    Frame frame;
    frame.name = joint.name;
    if (k > 0) frame.parent = FrameIndex{k - 1};
    frame.type = joint.prismatic ? JointType::kPrismatic : JointType::kRevolute;
    frame.variable.coefficients = VectorXd::Unit(n, k);
    place(frame, *joint.dh);
    description.frames.push_back(frame);
  }
  Frame tip;
  tip.name = "tip";
  tip.parent = FrameIndex{n - 1};
  tip.variable.coefficients = VectorXd::Zero(n);
  tip.A = from_eigen(arm.T_last_tip);
  description.frames.push_back(tip);
  return Model(description);
}

IoConfig nominal_config(const ArmFacts& arm) {
  RobotConfig robot;
  robot.name = arm.name;
  robot.hardware = "QLA1";
  robot.pots_to_actuators = arm.pots_to_actuators;
  for (const ArmActuator& actuator : arm.actuators) {
    const double distance = actuator.prismatic ? kPotToleranceLength : kPotTolerance;
    robot.pot_tolerances.push_back({robot.size(), distance, kPotLatency});
    robot.actuators.push_back(nominal_actuator(actuator, arm.boards));
  }
  IoConfig config;
  config.robots.push_back(std::move(robot));
  return config;
}

}  // namespace veridyn::dvrk
