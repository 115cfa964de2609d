#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "veridyn/control/safety_supervisor.hpp"
#include "veridyn/cooperation/scenario_run.hpp"
#include "dvrk/config/io_config.hpp"

namespace veridyn::dvrk {

/// The boards of one arm of a scenario.
struct CooperatingArm {
  RobotConfig robot;
  MatrixXd coupling;  ///< empty: identity
  std::string host = "127.0.0.1";
  std::uint16_t port = 1394;
};

struct BoardCooperationOptions {
  /// Boards are emulated in this process, their arms joined through the scenario's world, and
  /// spoken to over UDP sockets all the same; hosts and ports of the arms are not used.
  bool emulate = false;
  int firmware = 8;
  double watchdog = 0.030;  ///< [s] of the boards
  /// Where member k's force comes from, see open_force_source(); empty: the emulated world's.
  std::vector<std::string> force_sources;
  std::vector<std::string> force_calibrations;  ///< files of `loadcell calibrate`; empty: newtons
  double power_timeout = 3.0;                   ///< [s]
  double hold = 1.0;     ///< [s] for which all is held after a fault, forces within relief_force
  double release = 1.0;  ///< [s] over which pretension is then given up, before power goes
  // Faults of emulated arms, for tests of the above.
  int silent_arm = -1, broken_arm = -1;
  double fault_at = 0.0;  ///< [s] of the scenario's time
};

/// How the end came, if it was not the scenario's.
enum class BoardEnd { kDone, kFault, kStopped };

struct BoardCooperationRun {
  ScenarioRun run;      ///< what was measured: tips from encoders, forces from sensors
  long cycles = 0, late = 0;  ///< Cycles of the loop; late: begun more than a period after their time
  double mean_cycle = 0.0, longest_cycle = 0.0;  ///< [s] from a cycle's begin to its end
  BoardEnd end = BoardEnd::kDone;
  int faulty_arm = -1;                             ///< whose fault stopped all, from 0
  std::string why;                                 ///< in words
  double fault_at = 0.0, off_at = 0.0;             ///< [s]: fault, power off everywhere
  double force_at_off = 0.0;                       ///< [N] largest true or measured, at power off
  double largest_force = 0.0;                      ///< [N] true where emulated, else measured
  double largest_force_after_fault = 0.0;          ///< [N]
  std::string report() const;
};

/// Runs a scenario on boards, from where the arms stand: one clock, one cooperative controller, a safety supervisor for every
/// arm. The fault of one (its supervisor, its boards, its line) stops all: motion ends and all arms
/// hold, giving way to forces beyond the scenario's relief_force, for `hold`; the pretension is
/// then given up over `release`; then power goes off everywhere.
///
/// The loop allocates nothing, throws nothing and waits for its clock and its sockets alone.
/// @throws InvalidInput  another number of boards than arms; as ArmSession::start().
BoardCooperationRun run_on_boards(const Scenario& scenario, const std::vector<CooperatingArm>& arms,
                                  const BoardCooperationOptions& options,
                                  const std::atomic<bool>& stop);

}  // namespace veridyn::dvrk
