#pragma once

#include <string>
#include <vector>

#include "veridyn/dvrk/arm_units.hpp"
#include "veridyn/dvrk/board_session.hpp"
#include "veridyn/dvrk/datagram_link.hpp"
#include "veridyn/dvrk/io_config.hpp"

namespace veridyn::dvrk {

struct ArmSessionOptions {
  MatrixXd actuator_to_joint;  ///< empty: identity
  CycleProtocol protocol = CycleProtocol::kAutomatic;
  double rate = 1500.0;  ///< [Hz] nominal; 0: timestamps are not judged
  std::size_t mtu = 1500;
  double watchdog = 0.030;  ///< [s]
  int pot_readings = 20;    ///< cycles of pots that give the encoders their start
};

/// The safety of a session as a configuration file has it: channels in use, largest currents, zero
/// currents, pots beside encoders.
/// @throws InvalidInput  other hardware than QLA boards.
SessionOptions session_options(const RobotConfig& robot, const ArmSessionOptions& options);

/// One arm on its boards, in SI units: a BoardSession with an ArmUnits on top. One cycle is
/// update(), set_torques(), commit(); none of them allocates or throws.
class ArmSession {
 public:
  /// @throws InvalidInput  as session_options(), BoardSession and ArmUnits.
  ArmSession(DatagramLink& link, const RobotConfig& robot, const ArmSessionOptions& options = {});

  /// Finds the boards; loads encoders that nobody has loaded yet, from the pots.
  /// @throws InvalidInput  as BoardSession::start(); an encoder cannot be loaded; velocities shall
  ///                       come from a firmware older than 7.
  void start();

  bool update() noexcept;
  const ArmState& state() const { return state_; }
  /// Joint torques [N m], [N]; (n), a stored vector. Held within the largest currents.
  void set_torques(const VectorXd& tau) noexcept;
  const ArmCommand& command() const { return command_; }
  void commit() noexcept { boards_.commit(); }

  int size() const { return units_.size(); }
  const RobotConfig& robot() const { return units_.robot(); }
  const MatrixXd& coupling() const { return units_.actuator_to_joint(); }
  BoardSession& boards() { return boards_; }
  /// Feedback of the board behind an actuator, for tables.
  const BoardFeedback& board_of(int actuator) const;
  /// Were encoders loaded from pots by start()?
  bool preloaded() const { return preloaded_; }

 private:
  void preload_from_pots();
  int place(int actuator) const { return places_[static_cast<size_t>(actuator)]; }

  DatagramLink& link_;
  ArmSessionOptions options_;
  ArmUnits units_;
  BoardSession boards_;
  std::vector<int> places_;  ///< of the board behind each actuator
  std::vector<RawActuator> raw_;
  ArmState state_;
  ArmCommand command_;
  bool preloaded_ = false;
};

}  // namespace veridyn::dvrk
