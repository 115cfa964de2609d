#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

#include "cooperation/empty_run.hpp"
#include "veridyn/cooperation/scenario_run.hpp"

// The report of a run, on runs filled in by hand.

namespace veridyn {
namespace {

// A complete run of a phase, with a member of 5 N that was tracked within 0.2 N, at rest within 0.1 N.
ScenarioRun good() {
  ScenarioRun run;
  run.name = "made up";
  run.engine = "veridyn";
  run.arms = {"left", "right"};
  run.members = {"rope"};
  run.time = VectorXd::LinSpaced(3, 0.5, 1.5);
  PhaseFigures phase;
  phase.phase = "pull";
  phase.to = phase.duration = 1.5;
  phase.position_error = 2e-3;
  phase.final_position_error = 1e-3;
  MemberFigures rope;
  rope.member = "rope";
  rope.wanted = 5.0;
  rope.largest_error = 0.2;
  rope.steady_error = 0.1;
  rope.tracked = true;
  phase.members = {rope};
  run.phases = {phase};
  run.largest_force = 5.2;
  return run;
}

bool report_contains(const ScenarioRun& run, const std::string& words) { return run.report().find(words) != std::string::npos; }

TEST(ScenarioReport, ARunWithoutBoundsCountsAsMet) {
  const ScenarioRun run = good();
  EXPECT_TRUE(run.met());
  EXPECT_EQ(run.report().rfind("made up: 2 arms, 1.5 s simulated in 0 s by veridyn.\n", 0), 0U) << run.report();
  EXPECT_FALSE(report_contains(run, "asked")) << run.report();
  EXPECT_FALSE(report_contains(run, "held bodies"));
  EXPECT_TRUE(report_contains(run, "pull: leader at most 2 mm off its way, 1 mm at the end\nLargest force: 5.2 N.\n")) << run.report();
}

TEST(ScenarioReport, AnArmThatNeverStartedIsReported) {
  ScenarioRun run;
  run.name = "made up";
  run.engine = "boards";
  run.arms = {"left"};
  EXPECT_EQ(run.report().rfind("made up: 1 arm, 0 s on boards.\n", 0), 0U) << run.report();
  EXPECT_FALSE(report_contains(run, "largest, steady, mean"));
}

// A bound is met if the reached value is at most the bound; the report agrees with met().
TEST(ScenarioReport, EveryBoundIsEvaluatedAndReported) {
  struct Bound {
    const char* words;
    double reached;
    void (*ask)(ScenarioRun& run, double bound);
  };
  const Bound bounds[] = {
      {"pull: force within 0.2 N, asked ", 0.2, [](ScenarioRun& run, double b) { run.phases[0].asked_force_error = b; }},
      {"pull: at rest within 0.1 N, asked ", 0.1, [](ScenarioRun& run, double b) { run.phases[0].asked_steady_error = b; }},
      {"pull: places within 2 mm, asked ", 2e-3, [](ScenarioRun& run, double b) { run.phases[0].asked_position_error = b; }},
      {"pull: places within 3 mm, asked ", 3e-3,
       [](ScenarioRun& run, double b) {
         run.phases[0].asked_position_error = b;
         run.phases[0].body_error = 3e-3;
       }},
      {"Largest force: 5.2 N, asked ", 5.2, [](ScenarioRun& run, double b) { run.asked_largest_force = b; }},
  };
  for (const Bound& bound : bounds) {
    for (const double share : {1.0, 0.9}) {
      ScenarioRun run = good();
      bound.ask(run, share * bound.reached);
      EXPECT_EQ(run.met(), share == 1.0) << bound.words << share;
      EXPECT_TRUE(report_contains(run, bound.words)) << run.report();
      EXPECT_EQ(report_contains(run, ": met\n") || report_contains(run, ": met.\n"), share == 1.0) << run.report();
      EXPECT_EQ(report_contains(run, ": NOT met"), share != 1.0) << run.report();
    }
  }
}

TEST(ScenarioReport, HeldBodiesAreReported) {
  ScenarioRun run = good();
  run.phases[0].body_error = 3e-3;
  EXPECT_TRUE(report_contains(run, "pull: held bodies at most 3 mm off their way\n")) << run.report();
  EXPECT_TRUE(run.met());
}

// A released member is not evaluated; if there is no other member, a bound of forces is not met.
TEST(ScenarioReport, AnUntrackedForceMeetsNoBound) {
  for (const bool steady : {false, true}) {
    ScenarioRun run = good();
    run.phases[0].members[0].tracked = false;
    EXPECT_TRUE(run.met());
    (steady ? run.phases[0].asked_steady_error : run.phases[0].asked_force_error) = 1e3;
    EXPECT_FALSE(run.met());
    EXPECT_TRUE(report_contains(run, "pull: no force was tracked throughout: NOT met\n")) << run.report();
    MemberFigures other = run.phases[0].members[0];
    other.tracked = true;
    other.largest_error = other.steady_error = 0.3;
    run.phases[0].members.push_back(other);
    EXPECT_TRUE(run.met());
    EXPECT_TRUE(report_contains(run, "within 0.3 N, asked 1e+03 N: met\n")) << run.report();
  }
}

TEST(ScenarioReport, APhaseThatEndedEarlyDoesNotMeetItsBounds) {
  ScenarioRun run = good();
  run.phases[0].cut_short = true;
  run.phases[0].duration = 2.5;
  EXPECT_FALSE(run.met());
  EXPECT_TRUE(report_contains(run, "pull: cut short, 1.5 s of 2.5 s: NOT met\n")) << run.report();
  EXPECT_FALSE(report_contains(run, "leader at most"));
}

TEST(ScenarioReport, AStoppedEngineAndAHoldAreReported) {
  ScenarioRun run = good();
  run.state = CooperativeState::kSensorStuck;
  run.held_at = 0.75;
  EXPECT_TRUE(run.met());
  EXPECT_TRUE(report_contains(run, std::string("At 0.75 s the controller ") + describe(run.state) + ".\n")) << run.report();
  EXPECT_FALSE(report_contains(run, "Stopped at"));
  run.status = StepStatus::kRanAway;
  run.stopped_at = 1.25;
  EXPECT_FALSE(run.met());
  EXPECT_TRUE(report_contains(run, std::string("Stopped at 1.25 s: an arm ") + describe(run.status) + ".\n")) << run.report();
}

TEST(ScenarioReport, NonFiniteFiguresMeetNoBound) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  ScenarioRun run = good();
  run.phases[0].members[0].generated = nan;  // no rate was measured
  EXPECT_TRUE(report_contains(run, "         -\n")) << run.report();
  run.asked_largest_force = 10.0;
  EXPECT_TRUE(run.met());
  run.largest_force = nan;
  EXPECT_FALSE(run.met());
  EXPECT_TRUE(report_contains(run, ": NOT met.\n")) << run.report();
}

// As many fields as names, in one order: joints arm by arm, tips by name, members, then sensors of three axes.
TEST(ScenarioReport, RowsHaveAFieldForEveryName) {
  Scenario s;
  s.arms.resize(2);
  s.arms[0].name = "a";
  s.arms[0].start = VectorXd::Zero(2);
  s.arms[1].name = "b";
  s.arms[1].start = VectorXd::Zero(1);
  s.members.resize(1);
  s.members[0].name = "m";
  s.walls.resize(2);
  s.walls[0].name = "w";
  s.walls[1].name = "v";
  s.walls[1].sensor_axes = 3;
  ScenarioRun run = empty_run(s, "veridyn", 2);
  run.time << 0.5, 1.0;
  run.arm[1].q(1, 0) = 3.0;
  run.arm[0].tau(1, 1) = -2.0;
  run.arm[1].target(1, 2) = 7.0;
  run.member[0].wanted[1] = 5.0;
  run.member[2].measured[1] = 6.0;
  run.member[2].axes(1, 2) = 8.0;
  EXPECT_EQ(scenario_row_names(run),
            "t,q1,q2,q3,dq1,dq2,dq3,tau1,tau2,tau3,tip_a_x,tip_a_y,tip_a_z,motion_a_x,motion_a_y,motion_a_z,target_a_x,"
            "target_a_y,target_a_z,tip_b_x,tip_b_y,tip_b_z,motion_b_x,motion_b_y,motion_b_z,target_b_x,target_b_y,target_b_z,"
            "wanted_m,force_m,measured_m,x_f_m,wanted_w,force_w,measured_w,x_f_w,wanted_v,force_v,measured_v,x_f_v,"
            "measured_v_x,measured_v_y,measured_v_z");
  EXPECT_EQ(scenario_row(run, 1),
            "1,0,0,3,0,0,0,0,-2,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,7,5,0,0,0,0,0,0,0,0,0,6,0,0,0,8");
  const std::string first = scenario_row(run, 0), names = scenario_row_names(run);
  EXPECT_EQ(std::count(first.begin(), first.end(), ','), std::count(names.begin(), names.end(), ','));
}

TEST(ScenarioReport, TheFileHasTheHeaderAndEveryRow) {
  Scenario s;
  s.arms.resize(1);
  s.arms[0].name = "a";
  s.arms[0].start = VectorXd::Zero(1);
  ScenarioRun run = empty_run(s, "veridyn", 2);
  run.time << 0.5, 1.0;
  const std::string path = testing::TempDir() + "veridyn_rows_" + std::to_string(::getpid()) + ".csv";
  write_scenario_rows(run, path);
  std::ifstream file(path);
  const std::string content{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(content, scenario_row_names(run) + "\n" + scenario_row(run, 0) + "\n" + scenario_row(run, 1) + "\n");
  std::remove(path.c_str());
}

// A run that ends early keeps the rows that it has, of every signal.
TEST(ScenarioReport, EverySignalOfATruncatedRunHasEquallyManyRows) {
  Scenario s;
  s.arms.resize(1);
  s.arms[0].start = VectorXd::Zero(2);
  s.members.resize(1);
  s.walls.resize(1);
  s.walls[0].sensor_axes = 3;
  s.bodies.resize(1);
  ScenarioRun run = empty_run(s, "veridyn", 5);
  keep_first_rows(run, 3);
  EXPECT_EQ(run.time.size(), 3);
  for (const MatrixXd* m : {&run.arm[0].q, &run.arm[0].dq, &run.arm[0].tau, &run.arm[0].tip, &run.arm[0].motion, &run.arm[0].target,
                            &run.member[1].axes, &run.body[0].position, &run.body[0].wanted})
    EXPECT_EQ(m->rows(), 3);
  EXPECT_EQ(run.arm[0].q.cols(), 2);
  EXPECT_EQ(run.member[0].axes.rows(), 0);
  for (const MemberTrace& t : run.member) {
    for (const VectorXd* v : {&t.wanted, &t.force, &t.measured, &t.x_f, &t.rate, &t.tracked}) EXPECT_EQ(v->size(), 3);
  }
}

}  // namespace
}  // namespace veridyn
