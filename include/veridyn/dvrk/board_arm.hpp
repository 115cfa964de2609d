#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Where an arm's boards are, and how its motors are wired.
struct BoardArmOptions {
  std::string config = "PSM1";  ///< sawRobotIO1394 file (XML, JSON), or a known arm at nominal scales
  std::string robot;            ///< in the file, where it has several
  std::string instrument;       ///< of a known arm, which couples its discs
  std::string host = "127.0.0.1";
  std::uint16_t port = 1394;
  double rate = 1000.0;          ///< [Hz] of the cycle
  double watchdog = 0.030;       ///< [s] after which boards that hear nothing switch off
  double reply_timeout = 0.004;  ///< [s] for all replies of a cycle
};

/// One arm behind dVRK boards, real or emulated, for a control loop of one's own:
///
///   BoardArm arm({"PSM1"});
///   arm.power_on();
///   every cycle: arm.read();  arm.set_torques(control(arm.q(), arm.dq()));  arm.write();
///
/// The boards' safety stands between (docs/boards.md): watchdogs, currents, temperatures, supplies,
/// encoders and pots are checked with every read, and whatever is wrong switches off until
/// power_on() is called again. A cycle without set_torques() is one without current. Joints beyond
/// those that torques are given for are held where power found them, with the laboratory's gains of
/// a known arm. After the constructor nothing throws or allocates; read() blocks for at most
/// `reply_timeout`. The destructor switches off. One object serves one thread.
class BoardArm {
 public:
  /// Finds the boards, and loads encoders from the pots where nobody did since the boards woke up.
  /// @throws InvalidInput  no such file, robot or instrument; boards that do not answer, that have
  ///                       another firmware or hardware; encoders that cannot be loaded.
  explicit BoardArm(const BoardArmOptions& options);
  ~BoardArm();
  BoardArm(const BoardArm&) = delete;
  BoardArm& operator=(const BoardArm&) = delete;

  int joints() const;  ///< that the boards have motors for

  /// Reads and checks the boards. @returns whether what follows is new.
  bool read() noexcept;
  const VectorXd& q() const;    ///< (n) [rad], [m]
  const VectorXd& dq() const;   ///< (n) [rad/s], [m/s]
  const VectorXd& tau() const;  ///< (n) [N m], [N] by the measured currents

  /// For the next write(), within the largest currents. @param tau  (m <= n) [N m], [N] of the
  /// first joints; not finite: no current anywhere.
  void set_torques(const VectorXd& tau) noexcept;
  /// (n) What set_torques() made of them, for ModelErrorObserver::sent().
  const VectorXd& sent() const;
  /// Sends; once in every cycle, whatever happened.
  void write() noexcept;

  /// Begins to power up, also after a fault. @returns nullptr, or why not: fixed words.
  const char* power_on() noexcept;
  void power_off() noexcept;
  /// Power is up and brakes are open: torques count.
  bool ready() const;
  /// Power is wanted: it is up, or on its way.
  bool powered() const;
  /// What switched the arm off, in fixed words; nullptr: nothing.
  const char* fault() const noexcept;

  /// Switches off and asks the boards until they say so. @returns whether all of them did; if not,
  /// only the emergency stop helps. Blocks for a few cycles.
  bool shutdown() noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace veridyn
