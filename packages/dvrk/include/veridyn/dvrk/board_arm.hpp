#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Connection to an arm's boards, and the wiring of its motors.
struct BoardArmOptions {
  /// sawRobotIO1394 file (XML, JSON), or a known arm with nominal scales
  std::string config = "PSM1";
  std::string robot;            ///< robot in that file, if it has several
  std::string instrument;       ///< instrument of a known arm, which couples its discs
  std::string host = "127.0.0.1";
  std::uint16_t port = 1394;
  double rate = 1000.0;          ///< [Hz] rate of the cycle
  double watchdog = 0.030;       ///< [s] time without a command after which boards switch off
  double reply_timeout = 0.004;  ///< [s] limit for all replies of a cycle
};

/// One arm behind dVRK boards, real or emulated, for your own control loop:
///
///   BoardArm arm({"PSM1"});
///   arm.power_on();
///   every cycle: arm.read();  arm.set_torques(control(arm.q(), arm.dq()));  arm.write();
///
/// The boards' safety functions are active (packages/dvrk/docs/boards.md): watchdogs, currents, temperatures,
/// supplies, encoders and pots are checked with every read, and any fault switches off until power_on() is
/// called again. A cycle without set_torques() has zero current. Joints without given torques are held at
/// their position at power-on, with the PID gains of the known arm. After the constructor nothing
/// throws or allocates; read() blocks for at most `reply_timeout`. The destructor switches off. One object
/// serves one thread.
class BoardArm {
 public:
  /// Finds the boards, and initialises encoders from the pots if this was not done since power-on.
  /// @throws InvalidInput  no such file, robot or instrument; boards that do not answer or have
  /// another firmware or hardware; encoders that cannot be initialised.
  explicit BoardArm(const BoardArmOptions& options);
  ~BoardArm();
  BoardArm(const BoardArm&) = delete;
  BoardArm& operator=(const BoardArm&) = delete;

  int joints() const;  ///< joints with a motor on the boards

  /// Reads and checks the boards. @returns true if the values below are new.
  bool read() noexcept;
  const VectorXd& q() const;    ///< (n) [rad], [m]
  const VectorXd& dq() const;   ///< (n) [rad/s], [m/s]
  const VectorXd& tau() const;  ///< (n) [N m], [N] from the measured currents

  /// Sets the torques of the next write(), limited to the largest currents. @param tau  (m <= n) [N
  /// m], [N] of the first joints; a value that is not finite sets all currents to zero.
  void set_torques(const VectorRef& tau) noexcept;
  /// (n) torques of set_torques() after its limits, for ModelErrorObserver::set_sent_torques().
  const VectorXd& sent() const;
  /// Sends the commands; call it once in every cycle, also after a failed read.
  void write() noexcept;

  /// Starts powering up, also after a fault. @returns nullptr, or a fixed text with the reason for a refusal.
  const char* power_on() noexcept;
  void power_off() noexcept;
  /// Power is on and brakes are released: torques act.
  bool ready() const;
  /// Power was requested: it is on, or being switched on.
  bool powered() const;
  /// Fixed text of the fault that switched the arm off; nullptr: none.
  const char* fault() const noexcept;

  /// Switches off and polls the boards for confirmation. @returns true if all confirmed; if not,
  /// only the emergency stop helps. Blocks for a few cycles.
  bool shutdown() noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace veridyn
