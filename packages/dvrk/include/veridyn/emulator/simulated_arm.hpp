#pragma once

#include <cstddef>
#include <vector>

#include "veridyn/emulator/board_load.hpp"
#include "veridyn/dvrk/config/io_config.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/model/joint_sensors.hpp"
#include "veridyn/simulation/engine.hpp"

namespace veridyn::dvrk {

/// A simulated arm behind emulated boards: motor currents drive an Engine, its joints turn encoders
/// and pots, all through the scales and the coupling of a configuration file.
///
/// The model may have fewer joints than there are actuators: it then has the first ones, and the others do
/// not move. While no amplifier of the arm is on, it holds its position as with brakes, unless
/// falls_without_power() was called.
class SimulatedArm final : public BoardLoad {
 public:
  /// @param boards             ids, in the order of the emulator's boards.
  /// @param actuator_to_joint  (n x n) K; empty: identity.
  /// @param q                  initial joint positions of the model.
  /// @throws InvalidInput  more joints than actuators, a board that is not there, a K that is
  ///                       singular, of the wrong size or that mixes joints of the model with
  ///                       others.
  SimulatedArm(Engine& engine, const RobotConfig& robot, const MatrixXd& actuator_to_joint,
               const std::vector<int>& boards, const VectorRef& q);

  void advance(double seconds, const MotorDrive* drives, ChannelMotion* motions,
               std::size_t channels) noexcept override;

  /// Sets end stops (joints) [rad], [m] at which the model's joints stop. There are none at first.
  void set_end_stops(const VectorRef& lower, const VectorRef& upper);

  /// Sets errors of encoders, pots and currents, without delays: currents are those of the cycle. There are
  /// none at first. @throws InvalidInput  another number of joints.
  void set_sensors(const JointSensors& sensors);

  /// Removes the brakes: after its motors have had power, nothing holds the arm without it.
  void falls_without_power() { brakes_ = false; }

  /// Status of the last step; a failed engine does not move any more.
  StepStatus status() const { return status_; }
  /// Last joint torques (model's joints) [N m], [N].
  const VectorXd& tau() const { return tau_; }

 private:
  struct Motor {
    ActuatorConfig config;
    std::size_t channel = 0;  ///< index among the emulator's channels
  };

  void stop_at_ends() noexcept;  ///< puts joints beyond a stop back to it

  Engine& engine_;
  std::vector<Motor> motors_;
  std::vector<std::size_t> brake_channels_;
  MatrixXd joint_to_actuator_;
  MatrixXd actuator_to_pot_;  ///< actuator to pot positions; empty: pots are on the actuators
  MatrixXd joint_torque_;  ///< actuator to joint torques: inverse of K'
  JointSensors sensors_;
  VectorXd effort_, joint_effort_, q_, shown_q_, actuator_q_, pot_q_, tau_, rest_;
  VectorXd lower_, upper_, held_q_, held_dq_;  ///< end stops; empty: none
  bool parked_ = true, brakes_ = true, had_power_ = false;
  StepStatus status_ = StepStatus::kOk;
};

}  // namespace veridyn::dvrk
