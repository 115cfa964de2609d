#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "cooperation/scenario_models.hpp"
#include "emulator/joined_arms.hpp"
#include "dvrk/board_bench.hpp"
#include "veridyn/control/arm_state.hpp"
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

struct Drill {
  int line = 0;
  std::string words, scenario, command, fault;
  double pretension = 0.0, motors = 1.0, observer = -1.0;
  double found = 0.0, force = 0.0;
};

void PrintTo(const Drill& drill, std::ostream* out) { *out << "line " << drill.line << ": " << drill.words; }

std::vector<Drill> drills() {
  std::ifstream file(std::string(VERIDYN_SOURCE_DIR) + "/tests/dvrk/safety_drills.txt");
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
    if (cells.size() != 7) throw InvalidInput(text("safety_drills.txt:", number, ": found ", cells.size(), " cells, expected 7."));
    Drill d;
    d.line = number;
    d.words = line;
    d.scenario = cells[0];
    d.pretension = std::stod(cells[1]);
    d.motors = std::stod(cells[2]);
    d.command = cells[3];
    d.fault = cells[4];
    d.found = cells[5] == "-" ? -1.0 : std::stod(cells[5]);
    d.force = std::stod(cells[6]);
    out.push_back(d);
  }
  return out;
}

// What the world does, step by step, and nothing that the program under test says about it.
class Observer {
 public:
  struct Step {
    double time = 0.0, force = 0.0;
    std::vector<VectorXd> q, dq, tau;
    std::vector<char> driven;
  };

  explicit Observer(const Scenario& scenario) : scenario_(scenario) {
    for (std::size_t k = 0; k < scenario.arms.size(); ++k) {
      const Model real = scenario_models(scenario, k).real;
      tips_.emplace_back(real, Tip{scenario.arms[k].frame, scenario.arms[k].offset});
      VectorXd speed(real.joints());
      for (int i = 0; i < real.joints(); ++i)
        speed[i] = real.coordinates()[static_cast<std::size_t>(i)].limits.velocity;
      speeds_.push_back(speed);
    }
  }

  /// The supervisor's limits as bounds for one arm. A joint that is faster than `runaway` loses its
  /// power, but goes on to accelerate with all that its motor has until then. A held arm that does not
  /// slow down loses it after `held_seconds`; one that does stops within its speed over `braking`. The
  /// Jacobian's columns of these arms are at right angles.
  struct Bounds {
    double speed = 0.0;   // share of the velocity limits
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
            limits.runaway * (limits.held_seconds + 1.0 / limits.braking) * way.norm()};
  }

  void see(const EmulatedInstant& now) {
    Step step;
    step.time = now.time;
    step.force = now.force;
    for (const EmulatedInstant::Arm& arm : now.arms) {
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
    double off = 0.0;  // [s]
    std::vector<double> moved, speed_at_release;
  };

  // `end` is the time from the begin of the scenario to power off, as the program has it; the last
  // amplifier went off then.
  Verdict after(double fault, double release, double end) {
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
    for (std::size_t k = 0; k <= last; ++k) {
      const Step& step = steps_[k];
      if (step.time < begin + fault) continue;
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
    return out;
  }

 private:
  Scenario scenario_;
  std::vector<TipKinematics> tips_;
  std::vector<VectorXd> speeds_;
  std::vector<Step> steps_;
};

Scenario scenario_of(const Drill& drill) {
  Scenario s = board_example(drill.scenario);
  s.asked_largest_force = 0.0;
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

class SafetyDrills : public testing::TestWithParam<Drill> {};

TEST_P(SafetyDrills, NothingMovesThatShouldStand) {
  const Drill& drill = GetParam();
  Scenario scenario = scenario_of(drill);
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
  options.watch = [&](const EmulatedInstant& now) { observer.see(now); };
  const BoardCooperationRun done = run_on_boards(scenario, arms, options, stop);

  if (drill.found < 0.0) {  // it rides through, and is not hurt
    EXPECT_EQ(done.end, BoardEnd::kDone) << done.report();
    EXPECT_LE(done.largest_force, drill.force) << done.report();
    EXPECT_EQ(done.power, OffState::kConfirmed);
    return;
  }
  ASSERT_EQ(done.end, BoardEnd::kFault) << done.report();
  EXPECT_GE(done.fault_at, moment);
  EXPECT_LE(done.fault_at, moment + drill.found) << done.report();
  const Observer::Verdict seen = observer.after(done.fault_at, done.release_at, done.off_at);
  if (std::getenv("VERIDYN_DRILL_FIGURES") != nullptr)
    std::printf("DRILL %d found %.3f speed %.2f travel %.1f force %.2f left %.2f : %s\n%s", drill.line,
                done.fault_at - moment, seen.speed, 1e3 * seen.travel, seen.force, seen.left,
                drill.words.c_str(), done.report().c_str());
  Observer::Bounds bounds;
  for (std::size_t k = 0; k < arms.size(); ++k) {
    VectorXd torque(scenario.arms[k].start.size());
    for (Eigen::Index i = 0; i < torque.size(); ++i) {
      const ActuatorConfig& a = arms[k].robot.actuators[static_cast<std::size_t>(i)];
      torque[i] = std::abs(a.max_current / a.effort_to_amps);
    }
    const Observer::Bounds one = observer.bounds(k, torque, 1.0 / scenario.control.rate);
    bounds.speed = std::max(bounds.speed, one.speed);
    bounds.travel = std::max(bounds.travel, one.travel);
  }
  if (std::getenv("VERIDYN_DRILL_FIGURES") != nullptr)
    std::printf("BOUNDS speed %.2f travel %.1f\n", bounds.speed, 1e3 * bounds.travel);
  EXPECT_LE(seen.speed, bounds.speed) << done.report();
  EXPECT_LE(seen.travel, bounds.travel) << done.report();
  EXPECT_LE(seen.force, drill.force) << done.report();
  EXPECT_LE(seen.left, kLeft) << done.report();
  EXPECT_LE(seen.off, kToOff);
  // The report's words are true: a held arm stood, by the world's own account, and moved as far.
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

TEST(SafetyDrillsData, AreManyEnough) { EXPECT_GE(drills().size(), 120U); }

}  // namespace
}  // namespace veridyn::dvrk
