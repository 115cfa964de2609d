#include "emulator/simulated_arm.hpp"

#include <Eigen/LU>
#include <algorithm>

#include "dvrk/protocol/protocol.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

// Throws if a joint of the model depends on an actuator that does not move.
void require_apart(const MatrixXd& K, int joints, const std::string& name) {
  const auto rest = K.rows() - joints;
  require(K.topRightCorner(joints, rest).isZero() && K.bottomLeftCorner(rest, joints).isZero(),
          "arm '", name, "': its coupling mixes the model's ", joints,
          " joints with the others, expected a model of all ", K.rows(), ".");
}

}  // namespace

SimulatedArm::SimulatedArm(Engine& engine, const RobotConfig& robot,
                           const MatrixXd& actuator_to_joint, const std::vector<int>& boards,
                           const VectorRef& q)
    : engine_(engine), sensors_(std::vector<RecordedChannel>(static_cast<size_t>(engine.joints()))) {
  const int n = robot.size();
  const int joints = engine.joints();
  require(joints <= n, "arm '", robot.name, "': found a model of ", joints, " joints, but only ", n,
          " actuators.");
  require(q.size() == joints, "arm '", robot.name, "': found ", q.size(),
          " positions to start from, expected ", joints, ".");
  MatrixXd K = actuator_to_joint;
  if (K.size() == 0) K = MatrixXd::Identity(n, n);
  require(K.rows() == n && K.cols() == n && Eigen::FullPivLU<MatrixXd>(K).isInvertible(), "arm '",
          robot.name, "': expected a coupling of ", n, " x ", n, " that can be inverted.");
  require_apart(K, joints, robot.name);
  for (const ActuatorConfig& actuator : robot.actuators) {
    const auto place = std::find(boards.begin(), boards.end(), actuator.board);
    require(place != boards.end() && actuator.axis < kChannels, "arm '", robot.name,
            "': found an actuator on board ", actuator.board, " axis ", actuator.axis,
            ", which is not emulated.");
    if (actuator.brake) {
      const auto at = std::find(boards.begin(), boards.end(), actuator.brake->board);
      if (at != boards.end())
        brake_channels_.push_back(
            static_cast<std::size_t>(kChannels * (at - boards.begin()) + actuator.brake->axis));
    }
    motors_.push_back(
        {actuator, static_cast<std::size_t>(kChannels * (place - boards.begin()) + actuator.axis)});
  }
  joint_to_actuator_ = K.inverse();
  joint_torque_ = joint_to_actuator_.transpose();
  if (robot.pots_to_actuators.size() > 0) actuator_to_pot_ = robot.pots_to_actuators.inverse();
  effort_ = joint_effort_ = q_ = shown_q_ = actuator_q_ = pot_q_ = VectorXd::Zero(n);
  tau_ = rest_ = VectorXd::Zero(joints);
  q_.head(joints) = q;
  engine_.set_state(q, rest_);
}

void SimulatedArm::set_sensors(const JointSensors& sensors) {
  require(sensors.joints() == engine_.joints(), "sensors: found those of ", sensors.joints(),
          " joints, expected ", engine_.joints(), ", one per joint of the model.");
  sensors_ = sensors;
}

void SimulatedArm::set_end_stops(const VectorRef& lower, const VectorRef& upper) {
  require(lower.size() == engine_.joints() && upper.size() == engine_.joints(), "end stops: found ",
          lower.size(), " and ", upper.size(), ", expected ", engine_.joints(),
          ", one per joint of the model.");
  lower_ = held_q_ = held_dq_ = lower;
  upper_ = upper;
}

// Stops act without rebound: a joint at a stop has no velocity towards it.
void SimulatedArm::stop_at_ends() noexcept {
  if (lower_.size() == 0 || status_ != StepStatus::kOk) return;
  held_q_ = engine_.q();
  held_dq_ = engine_.dq();
  bool hit = false;
  for (Eigen::Index j = 0; j < held_q_.size(); ++j) {
    const bool below = held_q_[j]<lower_[j], above = held_q_[j]> upper_[j];
    if (!below && !above) continue;
    hit = true;
    held_q_[j] = below ? lower_[j] : upper_[j];
    held_dq_[j] = below ? std::max(0.0, held_dq_[j]) : std::min(0.0, held_dq_[j]);
  }
  if (hit) engine_.set_state(held_q_, held_dq_);
}

void SimulatedArm::advance(double seconds, const MotorDrive* drives, ChannelMotion* motions,
                           std::size_t channels) noexcept {
  bool any = false;
  for (const std::size_t k : brake_channels_) motions[k].current_bits = drives[k].bits;
  for (Eigen::Index i = 0; i < effort_.size(); ++i) {
    const Motor& motor = motors_[i];
    const MotorDrive& drive = drives[motor.channel];
    const bool driven = drive.powered && !drive.voltage_mode && motor.channel < channels;
    any = any || driven;
    const double amps = driven ? motor.config.amps_to_bits.inverse(drive.bits + kZeroCurrent) : 0.0;
    effort_[i] = amps / motor.config.effort_to_amps;
    motions[motor.channel].current_bits = motor.config.bits_to_amps.inverse(amps) - kZeroCurrent;
  }
  joint_effort_.noalias() = joint_torque_ * effort_;
  tau_ = joint_effort_.head(tau_.size());
  sensors_.correct_torques(tau_);
  had_power_ = had_power_ || any;
  const bool stands = !any && (brakes_ || !had_power_);
  if (stands && !parked_) {  // the brakes engage
    q_.head(tau_.size()) = engine_.q();
    engine_.set_state(engine_.q(), rest_);
  }
  parked_ = stands;
  if (!parked_ && seconds > 0.0 && status_ == StepStatus::kOk) {
    status_ = engine_.step(tau_, seconds);
    stop_at_ends();
    q_.head(tau_.size()) = engine_.q();
  }
  shown_q_ = q_;
  sensors_.add_position_errors(shown_q_.head(tau_.size()));
  actuator_q_.noalias() = joint_to_actuator_ * shown_q_;
  pot_q_ = actuator_q_;
  if (actuator_to_pot_.size() > 0) pot_q_.noalias() = actuator_to_pot_ * actuator_q_;
  for (Eigen::Index i = 0; i < actuator_q_.size(); ++i) {
    const Motor& motor = motors_[i];
    ChannelMotion& motion = motions[motor.channel];
    const ActuatorConfig& c = motor.config;
    motion.counts = actuator_q_[i] / c.bits_to_position;
    motion.pot_bits = c.bits_to_volts.inverse(c.volts_to_position.inverse(pot_q_[i]));
  }
}

}  // namespace veridyn::dvrk
