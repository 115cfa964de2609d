#pragma once

#include <string>
#include <vector>

#include "veridyn/dvrk/arms/arm_units.hpp"
#include "veridyn/dvrk/boards/board_session.hpp"
#include "veridyn/dvrk/run/brake_driver.hpp"

namespace veridyn::dvrk {

/// Connector of one actuator: index of its board among the ascending ids, and channel.
struct Socket {
  int place = 0;
  int channel = 0;
};

/// The boards of an arm in ascending order, brakes included, and the sockets of its actuators.
/// @throws InvalidInput  an axis that boards of this program do not have (above 3).
std::vector<int> boards_of(const RobotConfig& robot);
std::vector<Socket> sockets_of(const RobotConfig& robot);

/// Initialisation of encoders by start(), if this was not done since their board's start.
enum class Homing { kIfNeeded, kNever };

struct ArmSessionOptions {
  MatrixXd actuator_to_joint;  ///< (n x n) K; empty: identity
  CycleProtocol protocol = CycleProtocol::kAutomatic;
  double rate = 1500.0;  ///< [Hz] nominal; 0: timestamps are not judged
  std::size_t mtu = 1500;
  Access access = Access::kDrive;  ///< listening, start() neither writes nor loads encoders
  bool announce = false;           ///< see BusOptions
  bool firewire = false;           ///< the same for FireWire
  double watchdog = 0.030;         ///< [s]
  double reply_timeout = 0.020;    ///< [s] for all replies of a cycle
  double repeat_after = BusOptions().repeat_after;  ///< [s] a read without a reply is sent again
  CurrentFollowing follow;
  double stall = SessionOptions().stall;  ///< [s], see SessionOptions::stall
  /// A motor that moves by less meanwhile stands still: this share of its actuator's range. That of
  /// a pitch is half a degree, of an insertion 1.2 mm.
  double standstill = 0.005;
  Homing homing = Homing::kIfNeeded;
  int pot_readings = 100;  ///< cycles of pots whose mean gives the encoders their start
  /// Largest motion of a pot among them, peak to peak, in which it counts as resting: this share of
  /// its actuator's range.
  double pot_unrest = 0.02;
};

/// The safety of a session as a configuration file has it: boards and channels in use, zero and
/// largest currents by the calibration, pots beside encoders where pots sit on the actuators.
/// @throws InvalidInput  as boards_of(); other hardware than QLA boards; a rate that is negative.
SessionOptions session_options(const RobotConfig& robot, const ArmSessionOptions& options = {});

/// Result of loading the encoders from the pots.
struct HomingReport {
  bool done = false;
  std::string reason;   ///< why not, in one line
  VectorXd actuator_q;  ///< Positions of the actuators [rad, m]
  /// Actuators outside their soft limits by more than a pot's tolerance: pots are wrong, or the arm
  /// was pushed there.
  std::vector<int> outside_limits;
};

/// One arm at the level of joints: state in, torques out, the boards' safety between. A cycle is
///
///   arm.update();  ... controller on arm.state() ...  arm.set_torques(tau);  arm.commit();
///
/// None of the three throws or allocates. Currents flow in PowerState::kOn only; brakes open after
/// power-up, and torques act only when all of them are open. A cycle without set_torques() has zero
/// current; after a lost read the session keeps the last currents, for a limited number of cycles.
class ArmSession {
 public:
  /// @throws InvalidInput  as session_options(), BoardSession and ArmUnits.
  ArmSession(DatagramLink& link, const RobotConfig& robot, const ArmSessionOptions& options = {});

  /// Finds the boards, sets the watchdogs, and loads encoders according to the options. @throws
  /// InvalidInput  as BoardSession::start(); the encoders cannot be loaded; velocities of a
  /// firmware older than 7 are requested.
  void start();

  /// True if an encoder was never loaded since its board woke up: positions mean nothing.
  bool needs_homing() noexcept;

  /// Loads all encoders from the mean of the pots, and looks whether they took it. Only without
  /// power. Blocks for about 0.1 s. A robot without encoder preload, or one with a lookup table for
  /// its pots, cannot.
  const HomingReport& home();
  /// Encoders changed by the last start() or home(); empty if start() found them loaded.
  const HomingReport& homing() const { return homing_; }
  /// Were encoders loaded from pots by start() or home()?
  bool preloaded() const { return homing_.done; }

  /// Reads the boards, checks them and moves on with power-up. @returns whether state() is new.
  bool update() noexcept;
  const BoardArmState& state() const { return state_; }

  /// Torques of the joints [N m, N] for the next commit(); (n), a stored vector. Held within the
  /// largest currents.
  void set_torques(const VectorXd& tau) noexcept;
  /// The commands after limits.
  const ArmCommand& command() const { return command_; }
  void commit() noexcept;

  /// Begins to power up. @returns nullptr, or why not.
  const char* power_on() noexcept;
  void power_off() noexcept { boards_.power_off(); }

  /// Power is on, all brakes are open: torques count.
  bool ready() const;
  int size() const { return units_.size(); }
  const RobotConfig& robot() const { return units_.robot(); }
  const ArmUnits& units() const { return units_; }
  const MatrixXd& coupling() const { return units_.actuator_to_joint(); }
  BoardSession& boards() { return boards_; }
  const BoardSession& boards() const { return boards_; }
  /// Feedback of the board behind an actuator, for tables.
  const BoardFeedback& board_of(int actuator) const;
  double watchdog() const { return options_.watchdog; }  ///< [s] of the boards

 private:
  void require_velocities() const;
  void require_own_boards();
  void read_raw() noexcept;
  void command_brakes() noexcept;
  std::string average_pots(VectorXd& mean);
  std::string load_encoders(const VectorXd& actuator_q);
  std::string load_from_pots();

  DatagramLink& link_;
  ArmSessionOptions options_;
  ArmUnits units_;
  BoardSession boards_;
  std::vector<Socket> sockets_;
  std::vector<BrakeDriver> brakes_;
  std::vector<Socket> brake_sockets_;
  std::vector<RawActuator> raw_;
  BoardArmState state_;
  ArmCommand command_;
  bool commanded_ = false;
  bool homed_ = false;
  HomingReport homing_;
};

/// Checks whether another program drives the arm; writes nothing if a board answers. The two
/// packets of BusOptions::announce are sent only if none does, as after power-up. @throws
/// InvalidInput  a board has motor power, or none answers.
void require_no_power(DatagramLink& link, const RobotConfig& robot, ArmSessionOptions options);

}  // namespace veridyn::dvrk
