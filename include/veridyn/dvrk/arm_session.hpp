#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "veridyn/dvrk/arm_units.hpp"
#include "veridyn/dvrk/board_session.hpp"
#include "veridyn/dvrk/brake_driver.hpp"

namespace veridyn::dvrk {

/// Where one actuator is plugged in: place of its board among the ascending ids, and channel.
struct Socket {
  int place = 0;
  int channel = 0;
};

/// The boards of an arm in ascending order, brakes included, and the sockets of its actuators.
/// @throws InvalidInput  an axis that boards of this program do not have (above 3).
std::vector<int> boards_of(const RobotConfig& robot);
std::vector<Socket> sockets_of(const RobotConfig& robot);

/// What a board session must know to guard an arm: zero currents and largest currents by the
/// calibration, pots against encoders where pots sit on the actuators. Other settings stay.
/// @throws InvalidInput  as boards_of().
SessionOptions guard(const RobotConfig& robot, SessionOptions options = {});

struct ArmSessionOptions {
  SessionOptions session;
  /// Reads whose pots are averaged before encoders are loaded.
  int pot_readings = 100;
  double pot_period = 1.0 / 1500.0;  ///< [s] between them
  /// Largest motion of a pot, peak to peak, in which it counts as resting: this share of its
  /// actuator's range.
  double pot_unrest = 0.02;
};

/// What became of the encoders when they were loaded from the pots.
struct HomingReport {
  bool done = false;
  std::string reason;   ///< why not, in one line
  VectorXd actuator_q;  ///< where the actuators are [rad, m]
  /// Actuators outside their soft limits by more than a pot's tolerance: pots are wrong, or the arm
  /// was pushed there.
  std::vector<int> outside_limits;
};

/// One arm at the level of joints: state in, torques out, the boards' safety between. A cycle is
///
///   arm.update();  ... controller on arm.state() ...  arm.command(tau);  arm.commit();
///
/// update(), command() and commit() never throw or allocate. Currents flow in PowerState::kOn
/// alone; brakes open after power came up, and joints with a brake get torque only when all brakes
/// are open. A controller that does not command in a cycle leaves the arm without current.
class ArmSession {
 public:
  /// @throws InvalidInput  as guard() and ArmUnits.
  ArmSession(DatagramLink& link, const RobotConfig& robot,
             const MatrixXd& actuator_to_joint = MatrixXd(), const ArmSessionOptions& options = {});

  /// Finds the boards and sets the watchdogs. @throws InvalidInput  as BoardSession::start().
  void start();

  /// True if an encoder was never loaded since its board woke up: positions mean nothing.
  bool needs_homing() noexcept;

  /// Loads all encoders from the mean of the pots, and looks whether they took it. Only without
  /// power. Blocks for about 0.1 s. A robot without encoder preload, or one with a lookup table for
  /// its pots, cannot.
  HomingReport home();

  /// Reads the boards, checks them and moves on with power-up. @returns whether state() is new.
  bool update() noexcept;
  const ArmState& state() const { return state_; }

  /// Torques [N m, N] of the joints for the next commit(); clipped to the largest currents.
  const ArmCommand& command(const VectorXd& tau) noexcept;
  void commit() noexcept;

  /// Begins to power up. @returns nullptr, or why not.
  const char* power_on() noexcept;
  void power_off() noexcept { session_.power_off(); }

  /// Power is on, all brakes are open: torques count.
  bool ready() const;
  int size() const { return units_.size(); }
  const ArmUnits& units() const { return units_; }
  BoardSession& session() { return session_; }
  const BoardSession& session() const { return session_; }

 private:
  void read_raw() noexcept;
  void command_brakes() noexcept;
  bool average_pots(HomingReport& report, VectorXd& mean);
  bool load_encoders(HomingReport& report);

  DatagramLink& link_;
  ArmSessionOptions options_;
  ArmUnits units_;
  BoardSession session_;
  std::vector<Socket> sockets_;
  std::vector<BrakeDriver> brakes_;
  std::vector<Socket> brake_sockets_;
  std::vector<RawActuator> raw_;
  ArmState state_;
  ArmCommand command_;
  bool commanded_ = false;
  bool homed_ = false;
};

}  // namespace veridyn::dvrk
