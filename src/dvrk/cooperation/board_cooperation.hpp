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
    kLimp,       ///< its motors make no torque, and its boards say that all is well
    kWeak,       ///< its motors make half of the torque that their currents are for
    kReversed,   ///< its motors turn the wrong way, as wired so
    kStuck       ///< its amplifiers keep the currents of that moment, until they are off
  };
  Kind kind = Kind::kSilent;
  int arm = -1;     ///< Index of the arm, from 0
  double at = 0.0;  ///< [s]
};

/// Emulated boards and their world as they are at an instant.
struct EmulatedInstant {
  double time = 0.0;  ///< [s] of the world
  struct Arm {
    const VectorXd* q = nullptr;
    const VectorXd* dq = nullptr;
    const VectorXd* tau = nullptr;  ///< [N m], [N] of the motors; without power that of brakes
    bool driven = false;            ///< an amplifier is on
  };
  std::vector<Arm> arms;
  double force = 0.0;  ///< [N] largest of any member or wall
};

/// "silent:slave@2.5", or amplifier, power, encoder, jump, limp.
/// @throws InvalidInput  another form, an arm that is not there, a time that is not above zero.
EmulatedFault parse_emulated_fault(const std::string& text, const Scenario& scenario);

class JoinedBoards;
struct BoardCooperationOptions;
/// Makes emulated boards for the arms of a scenario, see emulator/joined_arms.hpp.
using EmulateBoards = std::function<std::unique_ptr<JoinedBoards>(
    const Scenario&, const std::vector<CooperatingArm>&, const BoardCooperationOptions&)>;

struct BoardCooperationOptions {
  /// Boards are emulated in this process, their arms joined through the scenario's world, and
  /// spoken to over UDP sockets all the same; hosts and ports of the arms are not used. Empty: the
  /// arms' own boards.
  EmulateBoards emulate;
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
  /// After each step of the emulated world, from the thread that serves the boards.
  std::function<void(const EmulatedInstant&)> watch;
  /// Before power the phases are planned from where the arms stand, and commands by line before
  /// they are taken. Drills leave it out, to come to where motors saturate.
  bool planned = true;
  /// Before power the scenario is simulated, its faults left out, where it asks for something.
  bool rehearsed = true;
  /// The rows go to this file while they are made; its first line then says that it is incomplete.
  /// write_scenario_rows() replaces it. Empty: not.
  std::string rows;
  /// Commands from here take the place of the scenario's phases; not owned. Null: the phases.
  /// `live.engine` and `live.hold` mean nothing here, `live.pace` to a stepped clock alone.
  LineSource* lines = nullptr;
  LiveOptions live;
  LiveReport live_report;
};

/// How the end came, if it was not the scenario's.
enum class BoardEnd { kDone, kFault, kStopped };

/// What an arm did between the first fault and the time at which pretension is given up, by its own
/// encoders.
struct ArmAfterFault {
  std::string name;
  bool known = true;          ///< its boards answered throughout
  double moved = 0.0;         ///< [m] largest way of its tip
  double rest_after = -1.0;   ///< [s] from which on it was at rest; below zero: it was not at the end
  double off_at = -1.0;  ///< [s] at which its own power went, before that of all; below zero: not
  /// It was under power and came to rest.
  bool held() const { return known && rest_after >= 0.0 && off_at < 0.0; }
};

/// A fault that came after the first.
struct LaterFault {
  double at = 0.0;   ///< [s]
  std::string what;  ///< with its arm
};

/// A line for each of both, for reports.
std::string words_after_fault(const std::vector<ArmAfterFault>& arms,
                              const std::vector<LaterFault>& later);
/// "power is off", or that it is not confirmed for these arms.
std::string words_at_end(OffState power, const std::string& not_off);

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
  std::vector<ArmAfterFault> after_fault;  ///< one for each arm; empty: there was none
  std::vector<LaterFault> later;           ///< in the order in which they came
  std::string not_off;  ///< arms whose boards did not confirm that they are off
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
/// @throws InvalidInput  another number of boards than arms; as ArmSession::start(); before power: a
/// phase that cannot be carried out, an `ask` that simulation does not meet, a force sensor that gives
/// no good readings.
BoardCooperationRun run_on_boards(const Scenario& scenario, const std::vector<CooperatingArm>& arms,
                                  const BoardCooperationOptions& options,
                                  const std::atomic<bool>& stop);

}  // namespace veridyn::dvrk
