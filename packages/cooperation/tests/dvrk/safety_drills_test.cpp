#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "cooperation/scenario/scenario_models.hpp"
#include "emulator/joined_arms.hpp"
#include "dvrk/board_bench.hpp"
#include "veridyn/control/arm_state.hpp"
#include "veridyn/control/cooperative_controller.hpp"
#include "veridyn/control/safety_supervisor.hpp"
#include "veridyn/control/tip_kinematics.hpp"
#include "veridyn/cooperation/live.hpp"
#include "veridyn/math/require.hpp"

// Drills as data (safety_drills.txt): a scenario, a command, a fault at a moment, and bounds. Motors
// saturate as those of the robots do. Judged by an observer of the emulated world that takes nothing
// from the program but the moment at which it says that it found the fault.

namespace veridyn::dvrk {
namespace {

constexpr double kPull = 0.35, kTension = 0.45, kCommand = 0.5;  // [s]
constexpr double kHold = 0.3, kRelease = 0.3;                     // [s]
constexpr double kToOff = kHold + kRelease + 0.03;                // [s] from the fault to off
constexpr double kHeldTravel = 0.002;  // [m] by which report and observer may differ
constexpr double kLeft = 6.0;          // [N] when power goes
constexpr double kCyclesToOff = 5.0;   // measured, decided, sent, amplifier off, and a step of the world
// [s] between what happens and what is measured: filters of the velocities (100 Hz), force sensors
// that sample at 500 Hz and are 2 ms late.
constexpr double kSensed = 0.005;
constexpr double kArmPeriod = 1.0 / 8.0;  // [s] in which a position loop (8 Hz) answers what moves its arm

struct Drill {
  int line = 0;
  std::string words, scenario, command, fault;
  double pretension = 0.0, motors = 1.0;
  bool found = false;
};

void PrintTo(const Drill& drill, std::ostream* out) { *out << "line " << drill.line << ": " << drill.words; }

std::vector<Drill> drills() {
  std::ifstream file(std::string(VERIDYN_SOURCE_DIR) + "/packages/cooperation/tests/dvrk/safety_drills.txt");
  std::vector<Drill> out;
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (line.empty() || line[0] == '#') continue;
    std::vector<std::string> cells;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, '|');) {
      const auto first = cell.find_first_not_of(' '), last = cell.find_last_not_of(' ');
      cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
    }
    if (cells.size() != 6 || (cells[5] != "found" && cells[5] != "goes on"))
      throw InvalidInput(text("safety_drills.txt:", number, ": found ", line, ", expected six cells and 'found' or 'goes on' in the last."));
    Drill d;
    d.line = number;
    d.words = line;
    d.scenario = cells[0];
    d.pretension = std::stod(cells[1]);
    d.motors = std::stod(cells[2]);
    d.command = cells[3];
    d.fault = cells[4];
    d.found = cells[5] == "found";
    out.push_back(d);
  }
  return out;
}

// Records the true state of the world in each step, independently of the program under test.
class Observer {
 public:
  struct Step {
    double time = 0.0, force = 0.0;
    double speed = 0.0, energy = 0.0;  // largest share of a velocity limit; kinetic [J] of all arms
    std::vector<VectorXd> q, dq, tau;
    std::vector<char> driven;
  };

  explicit Observer(const Scenario& scenario) : scenario_(scenario) {
    for (std::size_t k = 0; k < scenario.arms.size(); ++k) {
      const Model real = scenario_models(scenario, k).real;
      tips_.emplace_back(real, Tip{scenario.arms[k].frame, scenario.arms[k].offset});
      states_.emplace_back(real, Tip{scenario.arms[k].frame, scenario.arms[k].offset});
      VectorXd speed(real.joints());
      for (int i = 0; i < real.joints(); ++i)
        speed[i] = real.coordinates()[i].limits.velocity;
      speeds_.push_back(speed);
    }
  }

  /// The supervisor's limits as bounds for one arm. A joint that is faster than `runaway` loses its
  /// power, but goes on to accelerate with all that its motor has until then. A held arm that does not
  /// slow down loses it after `held_seconds`; one that does stops within its speed over `braking`. The
  /// Jacobian's columns of these arms are at right angles.
  struct Bounds {
    double speed = 0.0;   // share of the velocity limits
    double before = 0.0;  // the same until the fault is found
    double travel = 0.0;  // [m]
  };
  Bounds bounds(std::size_t k, const VectorXd& torque, double period) const {
    const SafetyLimits limits;
    const ScenarioArm& arm = scenario_.arms[k];
    veridyn::ArmState state(scenario_models(scenario_, k).real, {arm.frame, arm.offset});
    state.update(arm.start, VectorXd::Zero(arm.start.size()));
    const VectorXd gain = torque.cwiseQuotient(state.mass_matrix().diagonal()).cwiseQuotient(speeds_[k]);
    const VectorXd way = state.tip().jacobian().topRows<3>().colwise().norm().transpose().cwiseProduct(speeds_[k]);
    return {limits.runaway + kCyclesToOff * period * gain.maxCoeff(),
            1.0 + (kCyclesToOff * period + kSensed) * gain.maxCoeff(),
            limits.runaway * (limits.held_seconds + 1.0 / limits.braking) * way.norm()};
  }

  void observe(const EmulatedInstant& now) {
    Step step;
    step.time = now.time;
    step.force = now.force;
    for (std::size_t a = 0; a < now.arms.size(); ++a) {
      const EmulatedInstant::Arm& arm = now.arms[a];
      states_[a].update(*arm.q, *arm.dq);
      step.energy += 0.5 * arm.dq->dot(states_[a].mass_matrix() * *arm.dq);
      step.speed = std::max(step.speed, arm.dq->cwiseQuotient(speeds_[a]).cwiseAbs().maxCoeff());
      step.q.push_back(*arm.q);
      step.dq.push_back(*arm.dq);
      step.tau.push_back(*arm.tau);
      step.driven.push_back(arm.driven ? 1 : 0);
    }
    steps_.push_back(step);
  }

  struct Verdict {
    double speed = 0.0;   // share of the velocity limits
    double travel = 0.0;  // [m] of a tip under power
    double force = 0.0, left = 0.0;
    /// [N] that the springs carry at most if all kinetic energy that the arms have after the fault goes
    /// into one of them, on top of what is in it.
    double force_of_energy = 0.0;
    double off = 0.0;  // [s]
    double speed_before = 0.0;  // until the fault was found
    double witness = -1.0;  // [s] at which the world first left the documented limits
    std::vector<double> moved, speed_at_release;
  };

  // `end` is the time from the begin of the scenario to power off, as the program has it; the last
  // amplifier went off then.
  Verdict after(double moment, double fault, double release, double end) {
    std::size_t last = 0;
    for (std::size_t k = 0; k < steps_.size(); ++k) {
      for (const char driven : steps_[k].driven) last = driven != 0 ? k : last;
    }
    const double begin = steps_[last].time - end;
    Verdict out;
    out.left = steps_[last].force;
    out.off = end - fault;
    out.moved.assign(tips_.size(), 0.0);
    out.speed_at_release.assign(tips_.size(), 0.0);
    std::vector<std::optional<Eigen::Vector3d>> from(tips_.size());
    double energy = 0.0, at_fault = scenario_.control.relief_force;
    for (std::size_t k = 0; k <= last; ++k) {
      const Step& step = steps_[k];
      const bool beyond = step.speed > 1.0 || step.force > scenario_.control.largest_force;
      if (step.time >= begin + moment && beyond && out.witness < 0.0) out.witness = step.time - begin;
      if (step.time < begin + fault) {
        if (step.time >= begin + moment) out.speed_before = std::max(out.speed_before, step.speed);
        continue;
      }
      if (out.force == 0.0) at_fault = std::max(at_fault, step.force);
      energy = std::max(energy, step.energy);
      out.force = std::max(out.force, step.force);
      for (std::size_t a = 0; a < tips_.size(); ++a) {
        if (step.driven[a] == 0) continue;
        const double speed = step.dq[a].cwiseQuotient(speeds_[a]).cwiseAbs().maxCoeff();
        out.speed = std::max(out.speed, speed);
        if (step.time < begin + release) out.speed_at_release[a] = speed;
        tips_[a].update(step.q[a], step.dq[a]);
        if (!from[a]) from[a] = tips_[a].position();
        if (step.time < begin + release) out.moved[a] = std::max(out.moved[a], (tips_[a].position() - *from[a]).norm());
        out.travel = std::max(out.travel, (tips_[a].position() - *from[a]).norm());
      }
    }
    double stiffness = 0.0;
    for (const ScenarioMember& m : scenario_.members) stiffness = std::max(stiffness, m.stiffness);
    out.force_of_energy = std::sqrt(at_fault * at_fault + 2.0 * stiffness * energy);
    return out;
  }

 private:
  Scenario scenario_;
  std::vector<TipKinematics> tips_;
  std::vector<veridyn::ArmState> states_;
  std::vector<VectorXd> speeds_;
  std::vector<Step> steps_;
};

Scenario scenario_of(const Drill& drill) {
  Scenario s = board_example(drill.scenario);
  s.phases.clear();
  ScenarioPhase pull;
  pull.name = "pull";
  pull.duration = kTension;
  for (std::size_t m = 0; m < s.members.size(); ++m) {
    ScenarioCommand c;
    c.kind = ScenarioCommand::Kind::kForce;
    c.member = static_cast<int>(m);
    c.amount = drill.pretension;
    c.over = kPull;
    pull.commands.push_back(c);
  }
  ScenarioPhase command;
  command.name = "command";
  command.duration = kCommand;
  if (drill.command != "-")
    command.commands.push_back(std::get<ScenarioCommand>(parse_live_command(drill.command, s)));
  s.phases = {pull, command};
  return s;
}

/// [s] from its moment within which a fault is found, where that does not depend on how the arms
/// move; infinite where it does: then the observer's witness counts.
double derived_time(const Drill& drill, const Scenario& scenario, double moment) {
  const SafetyLimits supervisor;
  const SessionOptions boards;
  const BoardCooperationOptions how;
  const CooperativeOptions task;
  const double period = 1.0 / scenario.control.rate, cycles = kCyclesToOff * period;
  const std::string kind = drill.fault.substr(0, drill.fault.find_first_of(":@"));
  const double k = scenario.members.front().stiffness;
  // The length implies less force than the reading, by a stiffness that may be off, once the wanted force has
  // arrived; or the torques say something else.
  const auto disagrees = [&](double rate, double way) {
    const double margin = task.drift_force + k * (task.drift_length + task.drift_way * way);
    const double waits = std::max(0.0, kPull - moment) + kArmPeriod + kSensed + cycles;
    return waits + std::min(task.drift_factor * margin / rate,
                            supervisor.force_disagreement / rate + supervisor.disagreement_seconds);
  };
  if (kind == "amplifier" || kind == "power" || kind == "jump") return cycles;
  if (kind == "silent") return boards.lost_reads * how.reply_timeout + cycles;
  if (kind == "sensor-stale") return scenario.control.largest_age + kSensed + cycles;
  if (kind == "limp") return supervisor.disagreement_seconds + kArmPeriod + kSensed + cycles;
  if (kind == "sensor-drift") {
    double way = 0.0;
    for (const ScenarioCommand& c : scenario.phases.back().commands) way += 2.0 * c.way.norm();
    return disagrees(std::abs(std::stod(drill.fault.substr(drill.fault.find(':') + 1))), way);
  }
  const bool moves = drill.command != "-";
  if (kind == "stuck" && moves) return boards.follow.cycles * period + kArmPeriod + cycles;
  if (kind == "encoder" && moves) return kArmPeriod + kSensed + cycles;
  // Infeasible commands are found before the run.
  if (drill.fault == "-" && scenario.phases.back().commands.front().kind != ScenarioCommand::Kind::kForce)
    return scenario.phases.back().commands.front().over + cycles;
  return std::numeric_limits<double>::infinity();
}

class SafetyDrills : public testing::TestWithParam<Drill> {};

TEST_P(SafetyDrills, FaultsAreDetectedInTimeAndMotionStaysWithinItsBounds) {
  const Drill& drill = GetParam();
  Scenario scenario = scenario_of(drill);
  const double asked = scenario.asked_largest_force;
  scenario.asked_largest_force = 0.0;
  BoardCooperationOptions options;
  options.emulate = emulate_boards;
  options.stepped = true;
  options.planned = options.rehearsed = false;
  options.hold = kHold;
  options.release = kRelease;
  std::atomic<bool> stop{false};
  double moment = kTension;
  const auto at = drill.fault.rfind('@');
  if (at != std::string::npos) moment = std::stod(drill.fault.substr(at + 1));
  if (drill.fault.rfind("sensor-", 0) == 0) {
    ScenarioFault fault;
    fault.kind = drill.fault.rfind("sensor-drift", 0) == 0   ? ScenarioFault::Kind::kSensorDrift
                 : drill.fault.rfind("sensor-stale", 0) == 0 ? ScenarioFault::Kind::kSensorStale
                                                             : ScenarioFault::Kind::kSensorStuck;
    if (fault.kind == ScenarioFault::Kind::kSensorDrift)  // "sensor-drift:BY@AT", [N/s]
      fault.by = std::stod(drill.fault.substr(drill.fault.find(':') + 1));
    fault.member = 0;
    fault.at = moment;
    scenario.faults.push_back(fault);
  } else {
    std::istringstream faults(drill.fault);
    for (std::string one; std::getline(faults, one, ' ');)
      if (one != "-") options.faults.push_back(parse_emulated_fault(one, scenario));
    if (!options.faults.empty()) moment = options.faults.front().at;
  }
  std::vector<CooperatingArm> arms = patient_side(scenario.arms.size());
  for (CooperatingArm& arm : arms)
    for (ActuatorConfig& a : arm.robot.actuators) a.max_current *= drill.motors;
  Observer observer(scenario);
  options.watch = [&](const EmulatedInstant& now) { observer.observe(now); };
  const BoardCooperationRun done = run_on_boards(scenario, arms, options, stop);

  if (!drill.found) {  // the fault is tolerated, and the scenario's bounds are met
    EXPECT_EQ(done.end, BoardEnd::kDone) << done.report();
    EXPECT_LE(done.largest_force, asked) << done.report();
    EXPECT_EQ(done.power, OffState::kConfirmed);
    return;
  }
  ASSERT_EQ(done.end, BoardEnd::kFault) << done.report();
  EXPECT_GE(done.fault_at, moment);
  const Observer::Verdict seen = observer.after(moment, done.fault_at, done.release_at, done.off_at);
  const double derived = derived_time(drill, scenario, moment);
  if (std::getenv("VERIDYN_DRILL_FIGURES") != nullptr)
    std::printf("DRILL %d found %.3f derived %.3f witness %.3f before %.2f speed %.2f travel %.1f force %.2f of %.2f left %.2f : %s\n%s", drill.line,
                done.fault_at - moment, derived, seen.witness < 0.0 ? -1.0 : seen.witness - moment, seen.speed_before, seen.speed,
                1e3 * seen.travel, seen.force, seen.force_of_energy, seen.left, drill.words.c_str(), done.report().c_str());
  EXPECT_LE(done.fault_at - moment, derived) << done.report();
  // The reported cause is the simulated one: a limp arm is not reported as a wrong sensor, nor vice versa.
  const bool limp = drill.fault.rfind("limp", 0) == 0 || drill.fault.rfind("weak", 0) == 0;
  const std::string accused = drill.fault.rfind("sensor", 0) == 0 ? done.report() : done.why;
  EXPECT_EQ(accused.find("motors without torque") != std::string::npos, limp) << done.report();
  // Whatever happens: five cycles after the world has left a limit it is found.
  if (seen.witness >= 0.0) {
    EXPECT_LE(done.fault_at, seen.witness + kSensed + kCyclesToOff / scenario.control.rate) << done.report();
  }
  Observer::Bounds bounds;
  for (std::size_t k = 0; k < arms.size(); ++k) {
    VectorXd torque(scenario.arms[k].start.size());
    for (Eigen::Index i = 0; i < torque.size(); ++i) {
      const ActuatorConfig& a = arms[k].robot.actuators[i];
      torque[i] = std::abs(a.max_current / a.effort_to_amps);
    }
    const Observer::Bounds one = observer.bounds(k, torque, 1.0 / scenario.control.rate);
    bounds.speed = std::max(bounds.speed, one.speed);
    bounds.before = std::max(bounds.before, one.before);
    bounds.travel = std::max(bounds.travel, one.travel);
  }
  if (std::getenv("VERIDYN_DRILL_FIGURES") != nullptr)
    std::printf("BOUNDS before %.2f speed %.2f travel %.1f\n", bounds.before, bounds.speed, 1e3 * bounds.travel);
  EXPECT_LE(seen.speed, bounds.speed) << done.report();
  EXPECT_LE(seen.travel, bounds.travel) << done.report();
  EXPECT_LE(seen.speed_before, bounds.before) << done.report();
  EXPECT_LE(seen.force, seen.force_of_energy) << done.report();
  EXPECT_LE(seen.left, kLeft) << done.report();
  EXPECT_LE(seen.off, kToOff);
  // The report agrees with the true state: a held arm was at rest, and its displacement is right.
  ASSERT_EQ(done.after_fault.size(), scenario.arms.size());
  const bool silent = drill.fault.find("silent") != std::string::npos;
  for (std::size_t k = 0; k < scenario.arms.size(); ++k) {
    const ArmAfterFault& arm = done.after_fault[k];
    if (!arm.held() || arm.rest_after > kHold || drill.fault.find("jump") != std::string::npos || drill.fault.find("encoder") != std::string::npos) continue;
    EXPECT_LE(seen.speed_at_release[k], 0.15) << arm.name << done.report();
    EXPECT_LE(seen.moved[k], arm.moved + kHeldTravel) << arm.name << done.report();
  }
  EXPECT_EQ(done.power, silent ? OffState::kUnknown : OffState::kConfirmed);
  EXPECT_EQ(done.report().find("NOT CONFIRMED") != std::string::npos, silent);
}

INSTANTIATE_TEST_SUITE_P(Data, SafetyDrills, testing::ValuesIn(drills()), [](const auto& of) {
  return "Line" + std::to_string(of.param.line);
});

TEST(SafetyDrillsData, HasAtLeast120Cases) { EXPECT_GE(drills().size(), 120U); }

}  // namespace
}  // namespace veridyn::dvrk
