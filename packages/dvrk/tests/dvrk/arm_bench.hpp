#pragma once

#include <Eigen/LU>
#include <string>
#include <vector>

#include "dvrk/arms/arm_facts.hpp"
#include "dvrk/run/arm_session.hpp"
#include "emulator/emulated_link.hpp"

namespace veridyn::dvrk {

constexpr double kCycle = 1.0 / 1500.0;

/// Motors that turn inertias against viscous friction, behind the calibration of a configuration.
class Inertias final : public BoardLoad {
 public:
  Inertias(const RobotConfig& robot, const VectorXd& start)
      : robot_(robot), sockets_(sockets_of(robot)), q(start), dq(VectorXd::Zero(start.size())) {
    current = effort = pots_ = dq;
    actuators_to_pots_ = MatrixXd::Identity(robot.size(), robot.size());
    if (robot.pots_to_actuators.size() > 0) actuators_to_pots_ = robot.pots_to_actuators.inverse();
  }

  void advance(double seconds, const MotorDrive* drives, ChannelMotion* motions,
               std::size_t channels) noexcept override {
    for (std::size_t k = 0; k < channels; ++k) motions[k].current_bits = drives[k].bits;
    brake_bits[0] = drives[kChannels].bits;
    pots_.noalias() = actuators_to_pots_ * q;
    for (std::size_t k = 0; k < sockets_.size(); ++k) {
      const ActuatorConfig& a = robot_.actuators[k];
      const auto i = static_cast<Eigen::Index>(k);
      const auto at = static_cast<std::size_t>(kChannels * sockets_[k].place + sockets_[k].channel);
      current[i] = drives[at].powered ? a.amps_to_bits.inverse(32768.0 + drives[at].bits) : 0.0;
      effort[i] = current[i] / a.effort_to_amps;
      dq[i] += seconds * (effort[i] - damping * dq[i]) / inertia;
      q[i] += seconds * dq[i];
      motions[at].counts = q[i] / a.bits_to_position + 1234.5;  // the encoder's zero is anywhere
      motions[at].pot_bits = a.bits_to_volts.inverse(a.volts_to_position.inverse(pots_[i] + shake));
      motions[at].current_bits = a.bits_to_amps.inverse(current[i]) - 32768.0;
    }
    shake = -shake;
  }

 private:
  RobotConfig robot_;
  std::vector<Socket> sockets_;
  MatrixXd actuators_to_pots_;
  VectorXd pots_;

 public:
  VectorXd q, dq, current, effort;
  double inertia = 0.02, damping = 0.05, shake = 0.0;
  double brake_bits[1] = {0.0};
};

/// An arm session on emulated boards in one process.
struct Bench {
  Bench(const RobotConfig& config, const MatrixXd& K, const VectorXd& start)
      : robot(config),
        load(config, start),
        emulator(setups(config), 3),
        link(emulator),
        arm(link, config, options(K)) {
    emulator.attach(&load);
    arm.start();
  }

  // Homing is a step of its own in most tests.
  static ArmSessionOptions options(const MatrixXd& K) {
    ArmSessionOptions all;
    all.actuator_to_joint = K;
    all.homing = Homing::kNever;
    return all;
  }

  static std::vector<BoardSetup> setups(const RobotConfig& config) {
    std::vector<BoardSetup> all;
    for (const int id : boards_of(config)) {
      all.emplace_back();
      all.back().id = id;
    }
    return all;
  }

  template <typename Controller>
  void run(double seconds, Controller controller) {
    for (double t = 0.0; t < seconds; t += kCycle) {
      arm.update();
      controller();
      arm.commit();
      link.wait(kCycle);
    }
  }
  void idle(double seconds) {
    run(seconds, [] {});
  }

  RobotConfig robot;
  Inertias load;
  BoardEmulator emulator;
  EmulatedLink link;
  ArmSession arm;
};

/// The example configuration of data/dvrk, and a place for its arm to start.
inline RobotConfig example() {
  return read_io_config(std::string(VERIDYN_SOURCE_DIR) +
                        "/data/dvrk/sawRobotIO1394-PSM1-example.xml")
      .robots.at(0);
}

inline VectorXd example_start() {
  VectorXd q(7);
  q << 0.3, -0.2, 0.12, 0.5, -0.4, 0.2, 0.1;
  return q;
}

}  // namespace veridyn::dvrk
