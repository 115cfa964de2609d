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

/// The boards of an arm in ascending order, those of brakes included, and the sockets of its actuators.
/// @throws InvalidInput  an axis above 3, which no supported board has.
std::vector<int> boards_of(const RobotConfig& robot);
std::vector<Socket> sockets_of(const RobotConfig& robot);

/// Initialisation of encoders by start(), if it was not done since their board started.
enum class Homing { kIfNeeded, kNever };

struct ArmSessionOptions {
  MatrixXd actuator_to_joint;  ///< (n x n) K; empty: identity
  CycleProtocol protocol = CycleProtocol::kAutomatic;
  double rate = 1500.0;  ///< [Hz] nominal; 0: timestamps are not judged
  std::size_t mtu = 1500;
  Access access = Access::kDrive;  ///< listening, start() neither writes nor loads encoders
  bool announce = false;           ///< see BusOptions
  bool firewire = false;           ///< see BusOptions
  double watchdog = 0.030;         ///< [s] watchdog of the boards
  double reply_timeout = 0.020;    ///< [s] limit for all replies of a cycle
  double repeat_after = BusOptions().repeat_after;  ///< [s] time after which a read without a reply is repeated
  CurrentFollowing follow;
  double stall = SessionOptions().stall;  ///< [s], see SessionOptions::stall
  /// A motor that moves by less than this share of its actuator's range during that time stands still. For a
  /// pitch that is half a degree, for an insertion 1.2 mm.
  double standstill = 0.005;
  Homing homing = Homing::kIfNeeded;
  int pot_readings = 100;  ///< number of cycles over which pots are averaged to initialise the encoders
  /// Largest peak-to-peak motion of a resting pot during these cycles, as a share of its actuator's range.
  double pot_unrest = 0.02;
};

/// The safety settings of a session from a configuration file: boards and channels in use, zero and largest
/// currents by the calibration, comparison of pots and encoders if pots are on the actuators.
/// @throws InvalidInput  as boards_of(); other hardware than QLA boards; a negative rate.
SessionOptions session_options(const RobotConfig& robot, const ArmSessionOptions& options = {});

/// Result of loading the encoders from the pots.
struct HomingReport {
  bool done = false;
  std::string reason;   ///< reason for a failure, in one line
  VectorXd actuator_q;  ///< Positions of the actuators [rad, m]
  /// Actuators outside their soft limits by more than a pot's tolerance: pots are wrong, or the arm
  /// was pushed there.
  std::vector<int> outside_limits;
};

/// One arm at the level of joints: state in, torques out, with the boards' safety in between. A cycle is
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

  /// True if an encoder was never loaded since its board started: positions are invalid.
  bool needs_homing() noexcept;

  /// Loads all encoders from the mean of the pots, and verifies them. Only without power. Blocks for about
  /// 0.1 s. Not possible for a robot without encoder preload, or with a lookup table for its pots.
  const HomingReport& home();
  /// Encoders changed by the last start() or home(); empty if start() found them loaded.
  const HomingReport& homing() const { return homing_; }
  /// True if start() or home() loaded the encoders from the pots.
  bool preloaded() const { return homing_.done; }

  /// Reads the boards, checks them and continues the power-up. @returns true if state() is new.
  bool update() noexcept;
  const BoardArmState& state() const { return state_; }

  /// Torques of the joints [N m, N] for the next commit(); (n), a stored vector. Limited to the largest
  /// currents.
  void set_torques(const VectorRef& tau) noexcept;
  /// The commands after limits.
  const ArmCommand& command() const { return command_; }
  void commit() noexcept;  ///< sends brake currents, and the torques if ready()

  /// Begins to power up. @returns nullptr, or the reason for a refusal.
  const char* power_on() noexcept;
  void power_off() noexcept { boards_.power_off(); }

  /// True if power is on and all brakes are open, so that torques act.
  bool ready() const;
  int joints() const { return units_.size(); }
  const RobotConfig& robot() const { return units_.robot(); }
  const ArmUnits& units() const { return units_; }
  const MatrixXd& coupling() const { return units_.actuator_to_joint(); }
  BoardSession& boards() { return boards_; }
  const BoardSession& boards() const { return boards_; }
  /// Feedback of the board behind an actuator, for tables.
  const BoardFeedback& board_of(int actuator) const;
  double watchdog() const { return options_.watchdog; }  ///< [s] watchdog of the boards

 private:
  void require_velocities() const;  ///< throws InvalidInput, see start()
  void require_own_boards();  ///< throws InvalidInput if a serial number differs from the configuration
  void read_raw() noexcept;  ///< fills raw_ from the last feedback
  void command_brakes() noexcept;  ///< releases them in PowerState::kOn, else engages them
  std::string average_pots(VectorXd& mean);  ///< mean [bits] of resting pots, (n)
  /// Both return the reason for a failure; empty after success. @param actuator_q  (n) [rad], [m].
  std::string load_encoders(const VectorRef& actuator_q);
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
