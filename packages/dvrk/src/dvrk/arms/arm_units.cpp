#include "dvrk/arms/arm_units.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

// The coupling K, identity if empty; throws InvalidInput if it does not fit the robot or is singular.
MatrixXd checked_coupling(const MatrixXd& K, const RobotConfig& robot) {
  const int n = robot.size();
  require(n > 0, "arm '", robot.name, "': found no actuators, expected at least one.");
  for (const ActuatorConfig& actuator : robot.actuators) {
    require(actuator.effort_to_amps > 0.0 && actuator.max_current > 0.0 &&
                actuator.bits_to_position != 0.0,
            "arm '", robot.name,
            "': found an actuator without drive or encoder, expected an arm that can be driven.");
  }
  if (K.size() == 0) return MatrixXd::Identity(n, n);
  require(K.rows() == n && K.cols() == n, "arm '", robot.name, "': found a coupling of ", K.rows(),
          " x ", K.cols(), ", expected ", n, " x ", n, ".");
  require(K.allFinite() && Eigen::FullPivLU<MatrixXd>(K).isInvertible(), "arm '", robot.name,
          "': found a singular coupling, expected one that can be inverted.");
  return K;
}

// [counts/s] by the firmware's estimate, or by the difference of counts; 0 without a previous reading.
double encoder_velocity(const ActuatorConfig& actuator, const RawActuator& raw,
                        std::int32_t previous, bool has_previous) {
  if (actuator.velocity_source == VelocitySource::kFirmware)
    return encoder_motion(raw.encoder).predicted;
  if (!has_previous || !(raw.seconds > 0.0)) return 0.0;
  return (encoder_counts(raw.encoder.position) - previous) / raw.seconds;
}

}  // namespace

BoardArmState::BoardArmState(int n)
    : q(VectorXd::Zero(n)),
      dq(q),
      tau(q),
      actuator_q(q),
      actuator_dq(q),
      actuator_tau(q),
      current(q),
      pot_q(q) {}

ArmCommand::ArmCommand(int n)
    : bits(static_cast<std::size_t>(n), 0x8000), current(VectorXd::Zero(n)), tau(current) {}

ArmUnits::ArmUnits(const RobotConfig& robot, const MatrixXd& actuator_to_joint)
    : robot_(robot),
      actuators_(robot.actuators),
      actuator_to_joint_(checked_coupling(actuator_to_joint, robot)),
      joint_to_actuator_(actuator_to_joint_.inverse()),
      joint_torque_(joint_to_actuator_.transpose()),
      actuator_torque_(actuator_to_joint_.transpose()),
      previous_(actuators_.size(), 0),
      pot_(VectorXd::Zero(robot.size())),
      effort_(pot_) {
  if (robot_.pots_to_actuators.size() == 0)
    robot_.pots_to_actuators = MatrixXd::Identity(size(), size());
  require(robot_.pots_to_actuators.rows() == size() && robot_.pots_to_actuators.cols() == size(),
          "arm '", robot.name, "': found a coupling of pots of ", robot_.pots_to_actuators.rows(),
          " x ", robot_.pots_to_actuators.cols(), ", expected ", size(), " x ", size(), ".");
}

VectorXd ArmUnits::joint_steps() const {
  VectorXd step(size());
  for (int i = 0; i < size(); ++i) step[i] = std::abs(actuators_[i].bits_to_position);
  return actuator_to_joint_.cwiseAbs() * step;
}

void ArmUnits::read(const RawActuator* raw, BoardArmState& state) noexcept {
  for (int i = 0; i < size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const ActuatorConfig& actuator = actuators_[k];
    const std::int32_t counts = encoder_counts(raw[i].encoder.position);
    state.actuator_q[i] = actuator.bits_to_position * counts;
    state.actuator_dq[i] =
        actuator.bits_to_position * encoder_velocity(actuator, raw[i], previous_[k], has_previous_);
    previous_[k] = counts;
    state.current[i] = actuator.bits_to_amps(raw[i].current);
    state.actuator_tau[i] = state.current[i] / actuator.effort_to_amps;
    pot_[i] = actuator.volts_to_position(actuator.bits_to_volts(raw[i].pot));
  }
  has_previous_ = true;
  state.q.noalias() = actuator_to_joint_ * state.actuator_q;
  state.dq.noalias() = actuator_to_joint_ * state.actuator_dq;
  state.tau.noalias() = joint_torque_ * state.actuator_tau;
  state.pot_q.noalias() = robot_.pots_to_actuators * pot_;
}

void ArmUnits::write(const VectorRef& tau, ArmCommand& command) noexcept {
  if (tau.size() != size() || !tau.allFinite()) {
    write_zero(command);
    command.valid = false;
    return;
  }
  effort_.noalias() = actuator_torque_ * tau;
  command.clipped = false;
  command.valid = true;
  for (int i = 0; i < size(); ++i) {
    const ActuatorConfig& actuator = actuators_[i];
    const double wanted = actuator.effort_to_amps * effort_[i];
    command.current[i] = std::clamp(wanted, -actuator.max_current, actuator.max_current);
    if (command.current[i] != wanted) command.clipped = true;
  }
  convert_currents(command);
}

void ArmUnits::write_zero(ArmCommand& command) noexcept {
  command.current.setZero();
  command.clipped = false;
  command.valid = true;
  convert_currents(command);
}

void ArmUnits::convert_currents(ArmCommand& command) noexcept {
  for (int i = 0; i < size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const LinearScale& to_bits = actuators_[k].amps_to_bits;
    command.bits[k] =
        nearest_word(to_bits(command.current[i]), nearest_word(to_bits.offset, 0x8000));
    effort_[i] = command.current[i] / actuators_[k].effort_to_amps;
  }
  command.tau.noalias() = joint_torque_ * effort_;
}

void ArmUnits::pot_positions(const VectorRef& mean_bits, VectorXd& actuator_q) noexcept {
  for (int i = 0; i < size(); ++i) {
    const ActuatorConfig& actuator = actuators_[i];
    pot_[i] = actuator.volts_to_position(actuator.bits_to_volts(mean_bits[i]));
  }
  actuator_q.noalias() = robot_.pots_to_actuators * pot_;
}

void ArmUnits::preload_words(const VectorRef& actuator_q, std::uint32_t* words) const noexcept {
  for (int i = 0; i < size(); ++i) {
    const double counts = actuator_q[i] / actuators_[i].bits_to_position;
    // Held at the ends here, so that no conversion overflows; NaN: zero.
    const double held = std::isnan(counts) ? 0.0 : std::clamp(counts, -1e8, 1e8);
    words[i] = preload_word(std::llround(held));
  }
}

}  // namespace veridyn::dvrk
