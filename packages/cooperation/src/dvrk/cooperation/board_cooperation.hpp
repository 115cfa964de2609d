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
    kSilent,     ///< its boards no longer answer
    kAmplifier,  ///< an amplifier has a fault
    kPower,      ///< its motor supply fails
    kEncoder,    ///< the encoders of its first board freeze
    kJump,       ///< the encoder of its first joint jumps by 0.05 rad (m), so that its supervisor trips
    kLimp,       ///< its motors produce no torque, while its boards report no fault
    kWeak,       ///< its motors produce half of the torque for their current
    kReversed,   ///< its motors turn in the wrong direction, as if miswired
    kStuck       ///< its amplifiers keep their present currents until they are off
  };
  Kind kind = Kind::kSilent;
  int arm = 0;      ///< index of the arm, from 0
  double at = 0.0;  ///< [s] time of the fault
};

/// State of emulated boards and their world at one instant.
struct EmulatedInstant {
  double time = 0.0;  ///< [s] time of the world
  struct Arm {
    const VectorXd* q = nullptr;
    const VectorXd* dq = nullptr;
    const VectorXd* tau = nullptr;  ///< [N m], [N] torques of the motors; without power those of the brakes
    bool driven = false;            ///< an amplifier is on
  };
  std::vector<Arm> arms;
  double force = 0.0;  ///< [N] largest force of any member or wall
};

/// "silent:slave@2.5", with any EmulatedFault::Kind: silent, amplifier, ..., stuck.
/// @throws InvalidInput  another form, an arm that is not there, a time that is not above zero.
EmulatedFault parse_emulated_fault(const std::string& text, const Scenario& scenario);

/// Bounds of the checks that detect failed motors, sensors and encoders. `veridyn-fault-checks` varies each
/// of them; ScenarioControl::drift_force is one more.
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
  /// Boards are emulated in this process. Their arms are joined through the scenario's world, and the
  /// communication still uses UDP sockets; hosts and ports of the arms are not used. Empty: the arms' own
  /// boards.
  EmulateBoards emulate;
  /// The time of emulated boards stops while this program computes: the run is independent of the machine's
  /// speed. False: the machine's time.
  bool stepped = false;
  int firmware = 8;
  double watchdog = 0.030;  ///< [s] watchdog of the boards
  FaultChecks checks;
  double current_noise = 0.0;  ///< [bits] standard deviation of emulated boards' measured currents
  /// [s] timeout of an arm's boards. A silent arm delays a cycle of the others by this time, three times,
  /// before it counts as failed.
  double reply_timeout = 0.004;
  /// Source of the force of member k, then of the walls, see open_force_source(); empty: that of the emulated
  /// world.
  std::vector<std::string> force_sources;
  std::function<std::unique_ptr<ForceSource>(const std::string&)> open_source = open_force_source;
  double sensor_patience = 2.0;  ///< [s] within which every sensor must have given good readings
  std::vector<std::string> force_calibrations;  ///< files of `loadcell calibrate`; empty: newtons
  double power_timeout = 3.0;                   ///< [s] within which all arms must have power
  double hold = 1.0;     ///< [s] for which all arms hold after a fault, with forces within relief_force
  double release = 1.0;  ///< [s] during which the pretension is released before power-off
  std::vector<EmulatedFault> faults;  ///< Faults of emulated arms, for drills
  /// Called after each step of the emulated world, from the thread that serves the boards.
  std::function<void(const EmulatedInstant&)> watch;
  /// Plans the phases before power-up from the present positions, and commands by line before their
  /// execution. Drills disable it to reach saturation of the motors.
  bool planned = true;
  /// Simulates the scenario before power-up, without its faults, if it has bounds.
  bool rehearsed = true;
  /// File to which the rows are written during the run; its first line marks it as incomplete.
  /// write_scenario_rows() replaces it. Empty: no file.
  std::string rows;
  /// Source of commands that replace the scenario's phases; not owned. Null: the phases. `live.engine` and
  /// `live.hold` have no effect here, `live.pace` only with a stepped clock.
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
  std::optional<double> rest_after;  ///< [s] after which it was at rest; nullopt: it was not at rest at the end
  std::optional<double> off_at;      ///< [s] at which its own power was cut, before that of all arms; nullopt: it was not
  /// True if it was powered and came to rest.
  bool held() const { return known && rest_after && !off_at; }
};

/// A fault after the first one.
struct LaterFault {
  double at = 0.0;   ///< [s] time of its detection
  std::string what;  ///< description of the fault and its arm
};

/// One line for each arm and each later fault, for reports.
std::string faults_text(const std::vector<ArmAfterFault>& arms,
                              const std::vector<LaterFault>& later);
/// "power is off", or that it is not confirmed for these arms.
std::string power_text(OffState power, const std::string& not_off);

struct BoardCooperationRun {
  ScenarioRun run;      ///< measurements: tips from encoders, forces from sensors
  long cycles = 0, late = 0;  ///< cycles of the loop; late: begun more than a period after their time
  double mean_cycle = 0.0, longest_cycle = 0.0;  ///< [s] duration of a cycle
  bool stepped = false;  ///< the clock stopped while the program computed
  BoardEnd end = BoardEnd::kDone;
  std::optional<int> faulty_arm = {};  ///< arm whose fault stopped the run, from 0
  std::string why;      ///< the reason in words
  double fault_at = 0.0;                  ///< [s] time at which it was detected
  double release_at = 0.0, off_at = 0.0;  ///< [s] times of the release of the pretension and of power-off everywhere
  double force_at_release = 0.0;          ///< [N] largest true or measured force when the release began
  double force_at_off = 0.0;              ///< [N] the same at power-off
  double largest_force = 0.0;             ///< [N] true if emulated, else measured
  double largest_force_after_fault = 0.0;  ///< [N] largest force after the fault
  std::vector<ArmAfterFault> after_fault;  ///< one for each arm; empty: no fault
  std::vector<LaterFault> later;           ///< later faults in the order of occurrence
  std::string not_off;  ///< arms whose boards did not confirm that they are off
  bool live = false;               ///< commands came from a line
  long commands = 0, refused = 0;  ///< commands from the line
  OffState power = OffState::kNotAsked;    ///< the worst answer of all boards
  bool met() const { return end == BoardEnd::kDone && run.met(); }
  std::string report() const;
};

/// Runs a scenario on boards, from the arms' present positions: one clock, one cooperative controller, a
/// safety supervisor for every arm. A fault of one arm (its supervisor, its boards, its link) stops all:
/// motion ends and all arms hold for `hold`, yielding to forces beyond the scenario's relief_force and
/// following a falling arm (TetherGuard); the pretension is then released over `release`, and power is
/// switched off everywhere. The loss of a line of commands has the same effect.
///
/// The loop never allocates or throws, and blocks on its clock and its sockets only.
/// @throws InvalidInput  another number of boards than arms; as ArmSession::start(); before power: a
/// phase that cannot be carried out, an `ask` that simulation does not meet, a force sensor that gives
/// no good readings.
BoardCooperationRun run_on_boards(const Scenario& scenario, const std::vector<CooperatingArm>& arms,
                                  const BoardCooperationOptions& options,
                                  const std::atomic<bool>& stop);

}  // namespace veridyn::dvrk
