#include "emulator/joined_arms.hpp"
#include "dvrk/cooperation/board_cooperation.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <thread>

#include "cooperation/empty_run.hpp"
#include "dvrk/board_bench.hpp"
#include "dvrk/cooperation/scenario_row_file.hpp"
#include "veridyn/cooperation/live.hpp"
#include "veridyn/math/require.hpp"
#include "support/refusal.hpp"

// Arms on emulated boards hold one object: UDP sockets, sessions, loops and supervisors as on real
// boards, and a simulated world between the motors and the encoders.

namespace veridyn::dvrk {
namespace {

TEST(BoardCooperation, TwoArmsKeepTheForceInASpring) {
  const Scenario scenario = board_example("two-psm-spring");
  const BoardCooperationRun done = on_emulated_boards(scenario);
  EXPECT_EQ(done.end, BoardEnd::kDone) << done.report();
  EXPECT_TRUE(done.met()) << done.report();
  EXPECT_EQ(done.late, 0);
  EXPECT_EQ(done.power, OffState::kConfirmed);
  EXPECT_LT(done.largest_force, 3.2);
  EXPECT_LT(done.force_at_off, 0.5);
  ASSERT_EQ(done.run.phases.size(), 3U);
  // What is printed as measured was: the member's rate is the change of its tension by its stiffness,
  // and the computer took time.
  EXPECT_GT(done.run.seconds, 0.01);
  const MemberTrace& spring = done.run.member[0];
  const Eigen::Index rows = spring.force.size();
  EXPECT_NEAR(spring.rate.sum() / scenario.control.rate,
              (spring.force[rows - 1] - spring.force[0]) / scenario.members[0].stiffness, 2e-5);
  EXPECT_GT(spring.rate.cwiseAbs().maxCoeff(), 1e-4);
  // The leader has reached its target by its own encoders: along x of the world, which
  // is x of its base.
  const MatrixXd& tip = done.run.arm[0].tip;
  EXPECT_NEAR(tip(tip.rows() - 1, 0) - tip(0, 0), 0.01, 2e-4);
}

TEST(BoardCooperation, ThreeArmsReduceTheForceOfOneMemberOfATriangle) {
  const BoardCooperationRun done = on_emulated_boards(board_example("three-psm-springs"));
  EXPECT_TRUE(done.met()) << done.report();
  EXPECT_EQ(done.power, OffState::kConfirmed);
  ASSERT_EQ(done.run.phases.size(), 3U);
  EXPECT_NEAR(done.run.phases[2].members[1].wanted, 0.5, 1e-6);
  EXPECT_LT(done.run.phases[2].largest_force_error(), 0.1);
}

// With the stepped clock no result depends on the speed of the machine.
TEST(BoardCooperation, RunsAreReproducibleBitForBit) {
  Scenario scenario = board_example("two-psm-spring");
  scenario.phases.resize(1);
  scenario.phases[0].duration = 0.5;
  const BoardCooperationRun a = on_emulated_boards(scenario);
  const BoardCooperationRun b = on_emulated_boards(scenario);
  EXPECT_EQ(a.run.member[0].force, b.run.member[0].force);
  EXPECT_EQ(a.run.arm[1].tau, b.run.arm[1].tau);
  EXPECT_EQ(a.cycles, b.cycles);
}

// In the machine's own time, which may be short: either the run is done and the force kept, or the
// watchdogs and the supervisors have stopped all. In both cases power is off and the force is small.
TEST(BoardCooperation, ARealTimeRunEndsNormallyOrSwitchesOffAfterAFault) {
  Scenario scenario = board_example("two-psm-spring");
  scenario.phases.resize(1);
  scenario.phases[0].duration = 0.6;
  for (ScenarioCommand& c : scenario.phases[0].commands) {
    c.over = 0.4;
    c.amount = 1.0;
  }
  std::optional<BoardCooperationRun> run;
  for (int trial = 0; trial < 3 && !run; ++trial) {
    try {
      run = on_emulated_boards(scenario, {}, false);
    } catch (const InvalidInput&) {  // boards that are not found within milliseconds
    }
  }
  if (!run) GTEST_SKIP() << "the machine is too busy to find boards within milliseconds";
  const BoardCooperationRun& done = *run;
  EXPECT_LT(done.largest_force, 6.0);
  if (done.end != BoardEnd::kDone) {
    EXPECT_FALSE(done.why.empty());
    EXPECT_GE(done.off_at, done.fault_at);
    return;
  }
  EXPECT_EQ(done.power, OffState::kConfirmed);
  EXPECT_EQ(done.run.time.size(), 600);
}

TEST(BoardCooperation, APhaseCutShortByAFaultDoesNotMeetItsBound) {
  Scenario scenario = board_example("two-psm-spring");
  scenario.phases.resize(1);
  scenario.phases[0].asked_force_error = 100.0;
  const BoardCooperationRun done =
      on_emulated_boards(scenario, {{EmulatedFault::Kind::kPower, 1, 0.3}});
  ASSERT_EQ(done.run.phases.size(), 1U);
  EXPECT_TRUE(done.run.phases[0].cut_short);
  EXPECT_FALSE(done.run.phases[0].met());
  EXPECT_NE(done.report().find("cut short"), std::string::npos) << done.report();
  EXPECT_EQ(done.report().find("tension: force within"), std::string::npos) << done.report();
}

TEST(BoardCooperation, RefusesBoardsSensorsAndFaultsThatDoNotFitTheScenario) {
  const Scenario scenario = board_example("two-psm-spring");
  BoardCooperationOptions options;
  std::atomic<bool> stop{false};
  options.emulate = emulate_boards;
  EXPECT_THROW(run_on_boards(scenario, patient_side(3), options, stop), InvalidInput);
  options.force_sources = {"udp:47121", "udp:47122"};
  EXPECT_THROW(run_on_boards(scenario, patient_side(2), options, stop), InvalidInput);
  options = {};
  options.stepped = true;
  options.force_sources = {"udp:47121"};
  EXPECT_THROW(run_on_boards(scenario, patient_side(2), options, stop), InvalidInput);
  EXPECT_EQ(parse_emulated_fault("limp:slave@2.5", scenario).arm, 1);
  for (const char* bad : {"limp", "limp:slave", "limp:slave@", "limp:slave@x", "limp:slave@-1",
                          "limb:slave@1", "limp:slav@1"})
    EXPECT_THROW(parse_emulated_fault(bad, scenario), InvalidInput) << bad;
}

// Tissue as Kelvin and Voigt have it beneath an impedance: at rest both stiffnesses share the way.
TEST(BoardCooperation, TissueForceAtRestFollowsFromBothStiffnessesInSeries) {
  const Scenario scenario = board_example("two-psm-tissue");
  const BoardCooperationRun done = on_emulated_boards(scenario);
  ASSERT_TRUE(done.met()) << done.report();
  const double tissue = scenario.walls[0].stiffness, impedance = scenario.control.stiffness[2];
  const double depth = -scenario.phases[1].commands[0].way.z() + scenario.walls[0].point.z();
  const VectorXd& force = done.run.member[1].force;
  EXPECT_NEAR(force[3990], depth * tissue * impedance / (tissue + impedance), 0.03);
  EXPECT_NEAR(done.run.member[1].measured[3990], force[3990], 0.05);
  EXPECT_LT(force.head(2000).maxCoeff(), 1e-9);
  EXPECT_LT(force.tail(200).maxCoeff(), 1e-9);
}

// The same with a sensor of three axes under tissue that drags: what the boards' loop has measured is
// what the emulated tissue does, whatever the tip's orientation.
TEST(BoardCooperation, AThreeAxisSensorMeasuresTheDragOfEmulatedTissue) {
  Scenario scenario = board_example("two-psm-tissue");
  scenario.walls[0].sensor_axes = 3;
  scenario.walls[0].drag = 60.0;
  scenario.phases.insert(scenario.phases.begin() + 2, scenario.phases[1]);
  scenario.phases[2].commands[0].way = {0.0, 0.01, 0.0};
  const BoardCooperationRun done = on_emulated_boards(scenario);
  ASSERT_TRUE(done.met()) << done.report();
  const MemberTrace& tissue = done.run.member[1];
  ASSERT_EQ(tissue.axes.rows(), done.run.time.size());
  const MatrixXd& tip = done.run.arm[1].tip;
  const Eigen::Index k = 4750;  // in the middle of the move along the surface
  const double speed = (tip(k + 20, 1) - tip(k - 20, 1)) / (done.run.time[k + 20] - done.run.time[k - 20]);
  EXPECT_GT(speed, 0.005);
  EXPECT_NEAR(tissue.axes(k, 1), -60.0 * speed, 0.1 * 60.0 * speed + 0.05);
  EXPECT_NEAR(tissue.axes(k, 2), tissue.force[k], 0.06);
  BoardCooperationOptions options;
  options.force_sources = {"udp:47121", "udp:47122"};
  const std::atomic<bool> stop{false};
  EXPECT_THROW(run_on_boards(scenario, patient_side(2), options, stop), InvalidInput);
}

class Lines final : public LineSource {
 public:
  explicit Lines(std::vector<std::string> lines) : lines_(std::move(lines)) {}
  bool next(std::string& line) override {
    if (closed()) return false;
    line = lines_[next_++];
    return true;
  }
  bool closed() const override { return next_ == lines_.size(); }

 private:
  std::vector<std::string> lines_;
  std::size_t next_ = 0;
};

// Boards by a stepped clock that are driven by lines, as fast as this machine computes.
BoardCooperationOptions line_options(LineSource& lines) {
  BoardCooperationOptions options;
  options.emulate = emulate_boards;
  options.stepped = true;
  options.hold = options.release = 0.5;
  options.lines = &lines;
  options.live.pace = 0.0;
  return options;
}

TEST(BoardCooperation, CommandLinesMoveTheArmsAndALostInputEndsTheRun) {
  const Scenario scenario = board_example("two-psm-spring");
  for (const bool quits : {true, false}) {
    Lines lines({"force spring 2 0.8", "wait 1", "leap 1", "move 0.005 0 0 0.5", "wait 0.8",
                 quits ? "quit" : "alive"});
    BoardCooperationOptions options = line_options(lines);
    std::vector<std::string> states, refusals;
    options.live_report.state = [&](const std::string& line) { states.push_back(line); };
    options.live_report.refused = [&](const std::string& line) { refusals.push_back(line); };
    const std::atomic<bool> stop{false};
    const BoardCooperationRun done = run_on_boards(scenario, patient_side(2), options, stop);
    EXPECT_EQ(done.end, quits ? BoardEnd::kDone : BoardEnd::kStopped) << done.report();
    EXPECT_EQ(done.power, OffState::kConfirmed);
    EXPECT_EQ(done.commands, quits ? 5 : 4);
    EXPECT_EQ(done.refused, 1);
    ASSERT_EQ(refusals.size(), 1U);
    EXPECT_NE(refusals[0].find("found 'leap'"), std::string::npos);
    EXPECT_LT(done.force_at_off, 0.5);
    ASSERT_GT(states.size(), 15U);
    double time = 0.0, x0 = 0.0, x1 = 0.0, force = 0.0;
    ASSERT_EQ(std::sscanf(states.front().c_str(), "t=%lf state=\"tracks\" master=%lf", &time, &x0), 2);
    ASSERT_EQ(std::sscanf(states.back().c_str(), "t=%lf state=\"tracks\" master=%lf", &time, &x1), 2);
    EXPECT_NEAR(x1 - x0, 0.005, 1e-4);
    ASSERT_EQ(std::sscanf(states.back().c_str() + states.back().find("spring="), "spring=%lf", &force), 1);
    EXPECT_NEAR(force, 2.0, 0.05);
  }
}

// A wait holds up no stop on boards either.
TEST(BoardCooperation, AStopIsExecutedImmediately) {
  class Timed final : public LineSource {
   public:
    bool next(std::string& line) override {
      static const std::pair<int, const char*> kLines[] = {
          {0, "move 0.01 0 0 2"}, {0, "wait 5"}, {300, "move -0.01 0 0 1"}, {600, "stop"}, {2600, "quit"}};
      if (next_ == 5 || kLines[next_].first > cycle_) {
        ++cycle_;
        return false;
      }
      line = kLines[next_++].second;
      return true;
    }
    bool closed() const override { return false; }

   private:
    int next_ = 0, cycle_ = 0;
  } lines;
  BoardCooperationOptions options = line_options(lines);
  std::vector<double> x;
  std::vector<std::string> refusals;
  options.live_report.state = [&](const std::string& line) { x.push_back(std::atof(line.c_str() + line.find("master=") + 7)); };
  options.live_report.refused = [&](const std::string& line) { refusals.push_back(line); };
  const std::atomic<bool> stop{false};
  const BoardCooperationRun done = run_on_boards(board_example("two-psm-spring"), patient_side(2), options, stop);
  EXPECT_EQ(done.end, BoardEnd::kDone) << done.report();
  EXPECT_EQ(done.commands, 4);
  EXPECT_EQ(done.refused, 1);
  ASSERT_EQ(refusals.size(), 1U);
  EXPECT_NE(refusals[0].find("1 line before it"), std::string::npos) << refusals[0];
  ASSERT_GT(x.size(), 14U);
  EXPECT_LT(x.size(), 25U);
  EXPECT_GT(x[8] - x[0], 2e-4);
  EXPECT_LT(x[8] - x[0], 0.006);
  EXPECT_NEAR(x[14], x[9], 1e-4);
}

// A load cell that is polled once a cycle and speaks from one poll to another.
class Cell final : public ForceSource {
 public:
  enum class Line { kReading, kNothing, kUnusable, kSpike, kBeyond };
  struct Speech {
    int from = 0, until = 1 << 30;  // polls that find a reading
    bool stuck = false;
    std::function<Line(int)> line = [](int) { return Line::kReading; };  // by poll
    double spike = 8.0;  // [N]
  };
  Cell(const Speech& speech, int& polls) : speech_(speech), polls_(polls) {}
  int poll() noexcept override {
    fresh_ = !fresh_;  // the channel polls until there is nothing more
    if (!fresh_) return 0;
    ++polls_;
    line_ = polls_ >= speech_.from && polls_ < speech_.until ? speech_.line(polls_) : Line::kNothing;
    if (line_ == Line::kUnusable) ++refused_;
    return line_ == Line::kNothing || line_ == Line::kUnusable ? 0 : 1;
  }
  double raw() const noexcept override {
    if (line_ == Line::kBeyond) return 1e300;
    return (speech_.stuck ? 0.25 : 1e-3 * (polls_ % 7)) + (line_ == Line::kSpike ? speech_.spike : 0.0);
  }
  long rejected_readings() const noexcept override { return refused_; }

 private:
  Speech speech_;
  int& polls_;
  bool fresh_ = false;
  Line line_ = Line::kNothing;
  long refused_ = 0;
};

struct Heard {
  BoardCooperationRun run;
  std::string refusal;
  int polls = 0;
};

// Two arms at rest, with that load cell.
Heard run_with_cell(const Cell::Speech& speech) {
  Scenario scenario = board_example("two-psm-spring");
  scenario.phases.resize(1);
  scenario.phases[0].duration = 0.5;
  scenario.phases[0].commands.clear();
  BoardCooperationOptions options;
  options.emulate = emulate_boards;
  options.stepped = true;
  options.hold = options.release = 0.2;
  options.sensor_patience = 0.4;
  options.rehearsed = false;
  options.force_sources = {"udp:5999"};
  Heard out;
  options.open_source = [&](const std::string&) { return std::make_unique<Cell>(speech, out.polls); };
  const std::atomic<bool> stop{false};
  try {
    out.run = run_on_boards(scenario, patient_side(2), options, stop);
  } catch (const InvalidInput& error) {
    out.refusal = error.what();
  }
  return out;
}

TEST(BoardCooperation, PowerIsRefusedIfASensorIsSilentStuckOrDead) {
  const int never = 1 << 30;
  for (const auto& [speech, words] : std::vector<std::pair<Cell::Speech, std::string>>{
           {{never}, "waits for its first reading"},
           {{0, never, true}, "is stuck"},
           {{0, 100}, "is dead"}}) {
    const Heard heard = run_with_cell(speech);
    EXPECT_NE(heard.refusal.find("no power"), std::string::npos) << heard.run.report();
    EXPECT_NE(heard.refusal.find("udp:5999 of member 'spring' " + words), std::string::npos) << heard.refusal;
    EXPECT_LT(heard.polls, 600);  // the patience, and not a run
  }
  const Heard sound = run_with_cell({});
  EXPECT_EQ(sound.refusal, "");
  EXPECT_EQ(sound.run.end, BoardEnd::kDone) << sound.run.report();
  // The run waits for a sensor that starts late.
  EXPECT_EQ(run_with_cell({150}).run.end, BoardEnd::kDone);
}

// A sensor that gives 25, 50 or 200 readings a second where the scenario assumes 500.
TEST(BoardCooperation, ASlowSensorIsNamedBeforePower) {
  for (const int every : {40, 20, 5}) {
    Cell::Speech speech;
    speech.line = [every](int poll) { return poll % every == 0 ? Cell::Line::kReading : Cell::Line::kNothing; };
    const Heard heard = run_with_cell(speech);
    EXPECT_NE(heard.refusal.find("no power"), std::string::npos) << heard.run.report();
    EXPECT_NE(heard.refusal.find("readings per second"), std::string::npos) << heard.refusal;
    EXPECT_NE(heard.refusal.find("the scenario counts on 500"), std::string::npos) << heard.refusal;
    EXPECT_EQ(heard.refusal.find("is dead"), std::string::npos) << heard.refusal;
  }
}

// Whatever `loadcell read` finds wrong with a line ends a run, in its words and within 20 ms of silence
// or of the first readings of that kind.
TEST(BoardCooperation, EverySensorFaultHoldsAllArmsUnderPower) {
  using Line = Cell::Line;
  struct Case {
    const char* words;
    std::function<Line(int)> line;  // from its first poll on
    double within = 0.02;           // [s]
    double spike = 8.0;
  };
  const std::vector<Case> cases = {
      {"is dead", [](int) { return Line::kNothing; }},
      {"comes over a damaged line", [](int k) { return k % 2 == 0 ? Line::kUnusable : Line::kReading; }},
      {"comes over a damaged line", [](int k) { return k % 10 != 0 ? Line::kUnusable : Line::kReading; }},
      {"is beyond its range", [](int) { return Line::kBeyond; }},
      {"jumps from one reading to the next", [](int k) { return k == 0 ? Line::kSpike : Line::kReading; }},
      {"reading jumps", [](int k) { return k == 0 ? Line::kSpike : Line::kReading; }, 0.02, 1.5},
  };
  const int at = run_with_cell({}).polls - 700;  // of the 500 cycles of the phase and 400 behind them
  for (const Case& one : cases) {
    Cell::Speech speech;
    speech.spike = one.spike;
    speech.line = [&](int poll) { return poll < at ? Line::kReading : one.line(poll - at); };
    const Heard heard = run_with_cell(speech);
    EXPECT_EQ(heard.refusal, "");
    EXPECT_EQ(heard.run.end, BoardEnd::kFault) << one.words;
    EXPECT_NE(heard.run.why.find(one.words), std::string::npos) << heard.run.why;
    EXPECT_NEAR(heard.run.fault_at, 0.2 + 0.5 * one.within, 0.5 * one.within + 0.002) << one.words;
    EXPECT_EQ(heard.run.power, OffState::kConfirmed);
  }
  // An occasional lost byte is no fault.
  Cell::Speech speech;
  speech.line = [](int poll) { return poll % 50 == 0 ? Line::kUnusable : Line::kReading; };
  EXPECT_EQ(run_with_cell(speech).run.end, BoardEnd::kDone);
}

// Infeasible commands, with the required words of each refusal.
struct Infeasible {
  const char* line;
  const char* why;
};
const Infeasible kInfeasible[] = {
    {"move 5 0 0 0.1", "arm "},
    {"move 0.08 0 0 0.3", "N m at joint pitch, expected at most 2.6"},
    {"move 0 0 0.5 5", "rad/s, expected at most 1.9"},
    {"move 1e308 0 0 1e308", "no finite place"},
    {"turn 0 0 1.5 0.05", "arm "},
    {"tighten 1 0.01", ""},
    {"arm slave 0 0.6 0 5", "the controller holds"},
    {"force spring 1000 0.1", "found a force of 1000 N, expected at most 12 N"},
    {"force spring nan 1", "found 'nan'"},
};

TEST(BoardCooperation, AnInfeasibleScenarioIsRefusedBeforePower) {
  for (const Infeasible& one : kInfeasible) {
    if (std::string(one.why).rfind("found 'nan'", 0) == 0) continue;  // a file cannot contain a NaN
    Scenario scenario = board_example("two-psm-spring");
    scenario.phases.resize(2);
    scenario.phases[1].commands = {
        std::get<ScenarioCommand>(parse_live_command(one.line, scenario))};
    BoardCooperationOptions options;
    options.emulate = emulate_boards;
    options.stepped = true;
    options.rehearsed = false;
    bool driven = false;
    options.watch = [&](const EmulatedInstant& now) {
      for (const EmulatedInstant::Arm& arm : now.arms) driven = driven || arm.driven;
    };
    const std::atomic<bool> stop{false};
    try {
      run_on_boards(scenario, patient_side(2), options, stop);
      ADD_FAILURE() << one.line;
    } catch (const InvalidInput& error) {
      const std::string said = error.what();
      EXPECT_NE(said.find(one.why), std::string::npos) << one.line << ": " << said;
      EXPECT_NE(said.find("phase 'move'"), std::string::npos) << said;
    }
    EXPECT_FALSE(driven) << one.line;
  }
}

TEST(BoardCooperation, AScenarioThatFailsInSimulationIsRefusedBeforePower) {
  Scenario scenario = board_example("two-psm-spring");
  scenario.phases.resize(1);
  scenario.phases[0].asked_force_error = 0.001;
  BoardCooperationOptions options;
  options.emulate = emulate_boards;
  options.stepped = true;
  const std::atomic<bool> stop{false};
  EXPECT_TRUE(refuses_with("asked 0.001 N: NOT met", [&] { run_on_boards(scenario, patient_side(2), options, stop); }));
}

// Options of a run by lines on stepped boards that keeps every refusal.
BoardCooperationOptions refusal_options(Lines& lines, std::vector<std::string>& refusals) {
  BoardCooperationOptions options;
  options.emulate = emulate_boards;
  options.stepped = true;
  options.hold = options.release = 0.3;
  options.lines = &lines;
  options.live.pace = 0.0;
  options.live_report.refused = [&](const std::string& line) { refusals.push_back(line); };
  return options;
}

// As lines they are refused one by one, and nothing moves; feasible lines between them are executed.
TEST(BoardCooperation, InfeasibleCommandsAreRefusedWithoutMotion) {
  const Scenario scenario = board_example("two-psm-spring");
  std::vector<std::string> words{"force spring 2 0.8", "wait 1"};
  for (const Infeasible& one : kInfeasible) words.push_back(one.line);
  for (const char* line : {"jog 100 0 0", "wait 0.3", "quit"}) words.push_back(line);
  Lines lines(words);
  std::vector<std::string> refusals;
  BoardCooperationOptions options = refusal_options(lines, refusals);
  double fastest = 0.0;
  options.watch = [&](const EmulatedInstant& now) {
    for (const EmulatedInstant::Arm& arm : now.arms)
      if (arm.driven) fastest = std::max(fastest, arm.dq->cwiseAbs().maxCoeff());
  };
  const std::atomic<bool> stop{false};
  const BoardCooperationRun done = run_on_boards(scenario, patient_side(2), options, stop);
  EXPECT_EQ(done.end, BoardEnd::kDone) << done.report();
  ASSERT_EQ(refusals.size(), std::size(kInfeasible) + 1);
  for (std::size_t k = 0; k < std::size(kInfeasible); ++k)
    EXPECT_NE(refusals[k].find(kInfeasible[k].why), std::string::npos) << refusals[k];
  EXPECT_NE(refusals.back().find("jog 100 0 0"), std::string::npos);
  EXPECT_LT(done.largest_force, 2.3);
  EXPECT_LT(fastest, 0.2);  // the spring is stretched and released
}

// A jog that is kept up ends before it leads where an arm cannot go.
TEST(BoardCooperation, AJogEndsBeforeAnArmReachesItsLimits) {
  const Scenario scenario = board_example("two-psm-spring");
  std::vector<std::string> words{"force spring 1 0.5", "wait 0.6"};
  for (int k = 0; k < 20; ++k) {
    words.push_back("jog 0 0 -0.05");
    words.push_back("wait 0.3");
  }
  words.push_back("quit");
  Lines lines(words);
  std::vector<std::string> refusals;
  BoardCooperationOptions options = refusal_options(lines, refusals);
  const std::atomic<bool> stop{false};
  const BoardCooperationRun done = run_on_boards(scenario, patient_side(2), options, stop);
  EXPECT_EQ(done.end, BoardEnd::kDone) << done.report();
  EXPECT_FALSE(refusals.empty());
  EXPECT_LT(done.largest_force, 2.0);
}

TEST(BoardCooperation, RowsAreWrittenDuringTheRun) {
  const std::string path = testing::TempDir() + "rows-as-they-come.csv";
  ScenarioRun run = empty_run(board_example("two-psm-spring"), "boards", 100);
  for (int k = 0; k < 100; ++k) run.time[k] = 0.001 * k;
  const auto lines_in = [&] {
    std::ifstream file(path);
    std::vector<std::string> out;
    for (std::string line; std::getline(file, line);) out.push_back(line);
    return out;
  };
  ScenarioRowFile file(path, run);
  file.count(60);
  std::vector<std::string> lines;
  for (int trial = 0; trial < 100 && lines.size() < 62; ++trial) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    lines = lines_in();
  }
  ASSERT_EQ(lines.size(), 62U);
  EXPECT_EQ(lines[0].rfind("# incomplete", 0), 0U);
  EXPECT_EQ(lines[1], scenario_row_names(run));
  EXPECT_EQ(lines[61], scenario_row(run, 59));
  write_scenario_rows(run, path);
  lines = lines_in();
  EXPECT_EQ(lines.size(), 101U);
  EXPECT_EQ(lines[0], scenario_row_names(run));
  std::remove(path.c_str());
}

// A disk that is full before the first row leaves no file, and an older one as it was.
TEST(ScenarioRowFile, AFullDiskWithoutARowLeavesNoFile) {
  const auto folder = std::filesystem::temp_directory_path() / ("veridyn-no-row-" + std::to_string(::getpid()));
  std::filesystem::create_directory(folder);
  const std::string path = (folder / "rows.csv").string();
  const Scenario scenario = board_example("two-psm-spring");
  const ScenarioRun run = empty_run(scenario, "boards", 100);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  for (const bool there : {false, true}) {
    if (there) std::ofstream(path) << "an older recording\n";
    const rlimit small{300, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    {
      ScenarioRowFile file(path, run);
      file.count(60);
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
    }
    ::setrlimit(RLIMIT_FSIZE, &before);
    int files = 0;
    for ([[maybe_unused]] const auto& one : std::filesystem::directory_iterator(folder)) ++files;
    EXPECT_EQ(files, there ? 1 : 0);
    if (!there) continue;
    std::string line;
    std::ifstream kept(path);
    std::getline(kept, line);
    EXPECT_EQ(line, "an older recording");
  }
  std::signal(SIGXFSZ, handler);
  std::filesystem::remove_all(folder);
}

// The report on an arm agrees with its encoders.
// A healthy run ends without a fault although its wanted force is beyond largest_force_error (2 N).
TEST(BoardCooperation, ReleasingAPretensionIsNotReportedAsAFault) {
  Scenario scenario = board_example("two-psm-string");
  scenario.phases.resize(1);
  scenario.asked_largest_force = 0.0;
  const BoardCooperationRun done = on_emulated_boards(scenario);
  EXPECT_EQ(done.end, BoardEnd::kDone) << done.report();
  EXPECT_GT(done.force_at_release, 2.5);
  EXPECT_LT(done.force_at_off, 0.5) << done.report();
}

TEST(BoardCooperation, TheReportNamesTheHeldArm) {
  Scenario scenario = board_example("two-psm-spring");
  scenario.phases.resize(1);
  const BoardCooperationRun done =
      on_emulated_boards(scenario, {{EmulatedFault::Kind::kReversed, 1, 1.2}, {EmulatedFault::Kind::kPower, 0, 1.4}});
  ASSERT_EQ(done.after_fault.size(), 2U);
  EXPECT_FALSE(done.after_fault[1].held()) << done.report();
  EXPECT_NE(done.report().find("NOT all arms were held"), std::string::npos) << done.report();
  ASSERT_FALSE(done.later.empty());
  for (const LaterFault& one : done.later) {
    EXPECT_GE(one.at, done.fault_at);
    EXPECT_NE(done.report().find("also: " + one.what), std::string::npos);
  }
}

TEST(BoardCooperation, ASignalReleasesThePretensionAndSwitchesOff) {
  Scenario scenario = board_example("two-psm-spring");
  BoardCooperationOptions options;
  options.emulate = emulate_boards;
  options.stepped = true;
  options.hold = options.release = 0.3;
  const std::atomic<bool> stop{true};
  const BoardCooperationRun done = run_on_boards(scenario, patient_side(2), options, stop);
  EXPECT_EQ(done.end, BoardEnd::kStopped);
  EXPECT_EQ(done.power, OffState::kConfirmed);
  EXPECT_FALSE(done.met());
}

}  // namespace
}  // namespace veridyn::dvrk
