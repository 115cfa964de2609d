#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/control/cooperative_controller.hpp"
#include "veridyn/control/load_cell.hpp"
#include "veridyn/control/safety_supervisor.hpp"
#include "veridyn/cooperation/live.hpp"
#include "veridyn/cooperation/scenario_run.hpp"
#include "veridyn/dvrk/boards/board_session.hpp"
#include "veridyn/dvrk/config/io_config.hpp"

namespace veridyn::dvrk {

/// The boards of one arm of a scenario.
struct CooperatingArm {
  RobotConfig robot;
  MatrixXd coupling;  ///< empty: identity
  std::string host = "127.0.0.1";
  std::uint16_t port = 1394;
};

/// Fault of an emulated arm at a time of the scenario.
struct EmulatedFault {
  enum class Kind {
    kSilent,     ///< its boards do not answer any more
    kAmplifier,  ///< an amplifier has a fault
    kPower,      ///< its motor supply fails
    kEncoder,    ///< the encoders of its first board freeze, whatever the joints do
    kJump,       ///< the encoder of its first joint jumps by 0.05 rad (m): its supervisor trips
    kLimp,       ///< its motors produce no torque, while its boards report no fault
    kWeak,       ///< its motors make half of the torque that their currents are for
    kReversed,   ///< its motors turn in the wrong direction, as if miswired
    kStuck       ///< its amplifiers keep the currents of that moment, until they are off
  };
  Kind kind = Kind::kSilent;
  int arm = 0;      ///< from 0
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

/// Bounds of the checks that find motors, sensors and encoders that fail. `veridyn-fault-checks` varies each;
/// ScenarioControl::drift_force is one more.
struct FaultChecks {
  CurrentFollowing follow;
  double force_disagreement = SafetyLimits().force_disagreement;      ///< [N]
  double disagreement_seconds = SafetyLimits().disagreement_seconds;  ///< [s]
  double drift_length = CooperativeOptions().drift_length;            ///< [m]
  double drift_way = CooperativeOptions().drift_way;
  double drift_factor = CooperativeOptions().drift_factor;
};

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
  /// Time of emulated boards stops while this program computes: the run is independent of the
  /// machine, and takes as long as it needs. Otherwise it is the machine's time.
  bool stepped = false;
  int firmware = 8;
  double watchdog = 0.030;  ///< [s] of the boards
  FaultChecks checks;
  double current_noise = 0.0;  ///< [bits] standard deviation of emulated boards' measured currents
  /// [s] timeout of an arm's boards; a silent arm costs the others this much in a cycle, three
  /// times, before it counts as failed.
  double reply_timeout = 0.004;
  /// Source of the force of member k, then of the walls, see open_force_source(); empty: the
  /// emulated world's.
  std::vector<std::string> force_sources;
  std::function<std::unique_ptr<ForceSource>(const std::string&)> open_source = open_force_source;
  double sensor_patience = 2.0;  ///< [s] in which every sensor must have given good readings
  std::vector<std::string> force_calibrations;  ///< files of `loadcell calibrate`; empty: newtons
  double power_timeout = 3.0;                   ///< [s]
  double hold = 1.0;     ///< [s] for which all is held after a fault, forces within relief_force
  double release = 1.0;  ///< [s] in which the pretension is released before power-off
  std::vector<EmulatedFault> faults;  ///< Faults of emulated arms, for drills
  /// After each step of the emulated world, from the thread that serves the boards.
  std::function<void(const EmulatedInstant&)> watch;
  /// Plans the phases before power-up from the present positions, and commands by line before their
  /// execution. Drills disable it to reach saturation of the motors.
  bool planned = true;
  /// Simulates the scenario before power-up, without its faults, if it has bounds.
  bool rehearsed = true;
  /// Writes the rows to this file during the run; its first line then says that it is incomplete.
  /// write_scenario_rows() replaces it. Empty: no file.
  std::string rows;
  /// Commands from here take the place of the scenario's phases; not owned. Null: the phases.
  /// `live.engine` and `live.hold` mean nothing here, `live.pace` to a stepped clock alone.
  LineSource* lines = nullptr;
  LiveOptions live;
  LiveReport live_report;
};

/// Reason for an early end.
enum class BoardEnd { kDone, kFault, kStopped };

/// Motion of an arm between the first fault and the release of the pretension, by its own encoders.
struct ArmAfterFault {
  std::string name;
  bool known = true;          ///< its boards answered throughout
  double moved = 0.0;         ///< [m] largest displacement of its tip
  std::optional<double> rest_after;  ///< [s] after which it was at rest; nothing: it was not at rest at the end
  std::optional<double> off_at;      ///< [s] at which its own power was cut, before that of all; nullopt: it was not
  /// True if it was powered and came to rest.
  bool held() const { return known && rest_after && !off_at; }
};

/// A fault that came after the first.
struct LaterFault {
  double at = 0.0;   ///< [s]
  std::string what;  ///< with its arm
};

/// A line for each of both, for reports.
std::string faults_text(const std::vector<ArmAfterFault>& arms,
                              const std::vector<LaterFault>& later);
/// "power is off", or that it is not confirmed for these arms.
std::string power_text(OffState power, const std::string& not_off);

struct BoardCooperationRun {
  ScenarioRun run;      ///< what was measured: tips from encoders, forces from sensors
  long cycles = 0, late = 0;  ///< Cycles of the loop; late: begun more than a period after their time
  double mean_cycle = 0.0, longest_cycle = 0.0;  ///< [s] from a cycle's begin to its end
  bool stepped = false;  ///< by a clock that stands still while the program computes
  BoardEnd end = BoardEnd::kDone;
  std::optional<int> faulty_arm = {};  ///< arm whose fault stopped the run, from 0
  std::string why;      ///< in words
  double fault_at = 0.0;                  ///< [s] at which it was found
  double release_at = 0.0, off_at = 0.0;  ///< [s]: the pretension is given up; power off everywhere
  double force_at_release = 0.0;          ///< [N] largest true or measured, when that began
  double force_at_off = 0.0;              ///< [N] the same at power-off
  double largest_force = 0.0;             ///< [N] true where emulated, else measured
  double largest_force_after_fault = 0.0;  ///< [N]
  std::vector<ArmAfterFault> after_fault;  ///< one for each arm; empty: no fault
  std::vector<LaterFault> later;           ///< in the order in which they came
  std::string not_off;  ///< arms whose boards did not confirm that they are off
  bool live = false;               ///< It ran by commands from a line.
  long commands = 0, refused = 0;  ///< Commands that came from the line
  OffState power = OffState::kNotAsked;    ///< the worst answer of any arm's boards
  bool met() const { return end == BoardEnd::kDone && run.met(); }
  std::string report() const;
};

/// Runs a scenario on boards, from the arms' present positions: one clock, one cooperative
/// controller, a safety supervisor for every arm. A fault of one arm (its supervisor, its boards,
/// its link) stops all: motion ends and all arms hold for `hold`, yielding to forces beyond the
/// scenario's relief_force and following a falling arm (TetherGuard); the pretension is then
/// released over `release`, and power is switched off everywhere. The loss of a line of commands
/// has the same effect.
///
/// The loop never allocates or throws, and blocks on its clock and its sockets only.
/// @throws InvalidInput  another number of boards than arms; as ArmSession::start(); before power: a
/// phase that cannot be carried out, an `ask` that simulation does not meet, a force sensor that gives
/// no good readings.
BoardCooperationRun run_on_boards(const Scenario& scenario, const std::vector<CooperatingArm>& arms,
                                  const BoardCooperationOptions& options,
                                  const std::atomic<bool>& stop);

}  // namespace veridyn::dvrk
