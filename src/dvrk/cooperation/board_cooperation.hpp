#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "veridyn/control/load_cell.hpp"
#include "veridyn/control/safety_supervisor.hpp"
#include "veridyn/cooperation/live.hpp"
#include "veridyn/cooperation/scenario_run.hpp"
#include "dvrk/boards/board_session.hpp"
#include "dvrk/config/io_config.hpp"

namespace veridyn::dvrk {

/// The boards of one arm of a scenario.
struct CooperatingArm {
  RobotConfig robot;
  MatrixXd coupling;  ///< empty: identity
  std::string host = "127.0.0.1";
  std::uint16_t port = 1394;
};

/// What becomes of an emulated arm at a time of the scenario.
struct EmulatedFault {
  enum class Kind {
    kSilent,     ///< its boards do not answer any more
    kAmplifier,  ///< an amplifier has a fault
    kPower,      ///< its motor supply goes
    kEncoder,    ///< the encoders of its first board stand still, whatever the joints do
    kJump,       ///< the encoder of its first joint jumps by 0.05 rad (m): its supervisor trips
    kLimp        ///< its motors make no torque, and its boards say that all is well
  };
  Kind kind = Kind::kSilent;
  int arm = -1;     ///< Index of the arm, from 0
  double at = 0.0;  ///< [s]
};

/// "silent:slave@2.5", or amplifier, power, encoder, jump, limp.
/// @throws InvalidInput  another form, an arm that is not there, a time that is not above zero.
EmulatedFault parse_emulated_fault(const std::string& text, const Scenario& scenario);

struct BoardCooperationOptions {
  /// Boards are emulated in this process, their arms joined through the scenario's world, and
  /// spoken to over UDP sockets all the same; hosts and ports of the arms are not used.
  bool emulate = false;
  /// Time of emulated boards stands still while this program computes: the run does not depend on
  /// the machine, and takes as long as it takes. Otherwise it is the machine's time.
  bool stepped = false;
  int firmware = 8;
  double watchdog = 0.030;  ///< [s] of the boards
  /// [s] in which an arm's boards must answer; it is what one silent arm costs the others in a
  /// cycle, three times, before it counts as lost.
  double reply_timeout = 0.004;
  /// Where the force of member k comes from, then that of the walls, see open_force_source();
  /// empty: the emulated world's.
  std::vector<std::string> force_sources;
  std::function<std::unique_ptr<ForceSource>(const std::string&)> open_source = open_force_source;
  double sensor_patience = 2.0;  ///< [s] in which every sensor must have given good readings
  std::vector<std::string> force_calibrations;  ///< files of `loadcell calibrate`; empty: newtons
  double power_timeout = 3.0;                   ///< [s]
  double hold = 1.0;     ///< [s] for which all is held after a fault, forces within relief_force
  double release = 1.0;  ///< [s] over which pretension is then given up, before power goes
  std::vector<EmulatedFault> faults;  ///< Faults of emulated arms, for drills
  /// Commands from here take the place of the scenario's phases; not owned. Null: the phases.
  /// `live.engine` and `live.hold` mean nothing here, `live.pace` to a stepped clock alone.
  LineSource* lines = nullptr;
  LiveOptions live;
  LiveReport live_report;
};

/// How the end came, if it was not the scenario's.
enum class BoardEnd { kDone, kFault, kStopped };

struct BoardCooperationRun {
  ScenarioRun run;      ///< what was measured: tips from encoders, forces from sensors
  long cycles = 0, late = 0;  ///< Cycles of the loop; late: begun more than a period after their time
  double mean_cycle = 0.0, longest_cycle = 0.0;  ///< [s] from a cycle's begin to its end
  BoardEnd end = BoardEnd::kDone;
  int faulty_arm = -1;  ///< Arm whose fault stopped all, from 0; -1: none in particular
  std::string why;      ///< in words
  double fault_at = 0.0;                  ///< [s] at which it was found
  double release_at = 0.0, off_at = 0.0;  ///< [s]: the pretension is given up; power off everywhere
  double force_at_release = 0.0;          ///< [N] largest true or measured, when that began
  double force_at_off = 0.0;              ///< [N] likewise at power off
  double largest_force = 0.0;             ///< [N] true where emulated, else measured
  double largest_force_after_fault = 0.0;  ///< [N]
  bool live = false;               ///< It ran by commands from a line.
  long commands = 0, refused = 0;  ///< Commands that came from the line
  OffState power = OffState::kNotAsked;    ///< the worst answer of any arm's boards
  bool met() const { return end == BoardEnd::kDone && run.met(); }
  std::string report() const;
};

/// Runs a scenario on boards, from where the arms stand: one clock, one cooperative controller, a
/// safety supervisor for every arm. The fault of one (its supervisor, its boards, its line) stops
/// all: motion ends and all arms hold, giving way to forces beyond the scenario's relief_force and
/// going along with an arm that falls (TetherGuard), for `hold`; the pretension is then given up
/// over `release`; then power goes off everywhere. The loss of a line of commands does the same.
///
/// The loop allocates nothing, throws nothing and waits for its clock and its sockets alone.
/// @throws InvalidInput  another number of boards than arms; a force sensor that gives no good
///                       readings, before any power; as ArmSession::start().
BoardCooperationRun run_on_boards(const Scenario& scenario, const std::vector<CooperatingArm>& arms,
                                  const BoardCooperationOptions& options,
                                  const std::atomic<bool>& stop);

}  // namespace veridyn::dvrk
