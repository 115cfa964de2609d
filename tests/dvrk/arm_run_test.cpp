#include "dvrk/run/arm_run.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>

#include "dvrk/arm_bench.hpp"
#include "dvrk/bad_link.hpp"
#include "dvrk/planar_arm.hpp"
#include "dvrk/rig.hpp"
#include "emulator/emulated_link.hpp"
#include "dvrk/run/controllers/joint_pid.hpp"
#include "dvrk/run/controllers/model_controller.hpp"
#include "dvrk/run/motion_check.hpp"
#include "emulator/simulated_arm.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/model_file.hpp"
#include "veridyn/simulation/plant.hpp"
#include "support/refusal.hpp"

// A whole arm in one process: client, boards, motors, encoders, with a clock of its own.

namespace veridyn::dvrk {
namespace {

std::string first_line(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

class ArmRun : public testing::Test {
 protected:
  static BoardSetup board() {
    BoardSetup setup;
    setup.id = 6;
    return setup;
  }

  ArmRun()
      : model_(read_model("planar-2r")),
        plant_(model_),
        emulator_({board()}),
        link_(emulator_),
        load_(plant_, planar_config(), MatrixXd(), {6}, Eigen::Vector2d(0.4, -0.7)) {
    emulator_.attach(&load_);
  }

  static MotionSamples motion(double seconds) {
    return swinging(seconds, Eigen::Vector2d(0.1, 0.1), 0.6);
  }

  Model model_;
  Plant plant_;
  BoardEmulator emulator_;
  EmulatedLink link_;
  SimulatedArm load_;
  std::atomic<bool> stop_{false};
};

TEST_F(ArmRun, EncodersStartFromPots) {
  ArmSession arm(link_, planar_config());
  arm.start();
  EXPECT_TRUE(arm.preloaded());
  ASSERT_TRUE(arm.update());
  EXPECT_NEAR(arm.state().q[0], 0.4, 1e-4);  // one bit of a pot: 8e-5
  EXPECT_NEAR(arm.state().q[1], -0.7, 1e-4);
  arm.start();
  EXPECT_FALSE(arm.preloaded());  // they have theirs
}

TEST_F(ArmRun, FollowsAMotionAndRecordsTheTorquesThatActed) {
  ArmSession arm(link_, planar_config());
  const MotionSamples wanted = motion(8.0);
  const RunResult run = run_motion(arm, link_, wanted, sensible_gains(model_), RunOptions(), stop_);
  ASSERT_TRUE(run.complete) << run.why << "\n" << arm.boards().faults().report();
  EXPECT_EQ(arm.boards().faults().report(), "");
  EXPECT_NEAR(run.rows.rows(), 8.0 * 1500, 20);
  EXPECT_EQ(run.timing.late, 0);
  double worst = 0.0;
  for (int k = 0; k < run.rows.rows(); ++k) {
    const double w = 2.0 * M_PI * 2 / 8.0;
    worst = std::max(
        worst, std::abs(run.rows.q(k, 0) + 0.5 - 0.6 * (1.0 - std::cos(w * run.rows.time[k]))));
  }
  EXPECT_LT(worst, 0.05);
  EXPECT_GT(worst, 1e-6);
  // Where both joints stand for an instant in the middle, torques are those of gravity and
  // acceleration: the energy that the motors gave is kinetic, potential and friction. Here: the
  // work of the recorded torques over the closed motion is the heat of friction, which is positive.
  double work = 0.0;
  for (int k = 1; k < run.rows.rows(); ++k)
    work += run.rows.tau.row(k).dot(run.rows.q.row(k) - run.rows.q.row(k - 1));
  double heat = 0.0;
  const double viscous[] = {0.8, 0.4}, dry[] = {1.2, 0.6};
  for (int k = 1; k < run.rows.rows(); ++k) {
    const double dt = run.rows.time[k] - run.rows.time[k - 1];
    for (int j = 0; j < 2; ++j) {
      const double v = (run.rows.q(k, j) - run.rows.q(k - 1, j)) / dt;
      heat += (viscous[j] * v * v + dry[j] * std::abs(v)) * dt;
    }
  }
  EXPECT_NEAR(work, heat, 0.03 * heat);
  EXPECT_FALSE(emulator_.board(0).status().power_requested());
}

class Untroubled final : public MotionController {
 public:
  void reset() noexcept override {}
  bool torques(const BoardArmState&, const JointReference&, const CycleTimes&, VectorXd&) noexcept override { return true; }
};

// The first actuator turns by the sum of both joints: a motion of the first joint alone does not tell where it will be.
TEST_F(ArmRun, SoftLimitsAreAskedOfActuatorsWhoseJointsAllMove) {
  ArmSessionOptions options;
  options.actuator_to_joint = (MatrixXd(2, 2) << 1.0, -1.0, 0.0, 1.0).finished();
  ArmSession arm(link_, planar_config(), options);
  const auto refused = [&](const VectorXd& q) {
    MotionSamples stands;
    stands.time = Eigen::Vector2d(0.0, 0.01);
    stands.q = VectorXd::Ones(2) * q.transpose();
    stands.dq = MatrixXd::Zero(2, q.size());
    return refusal([&] { MotionCheck(arm, Untroubled(), q.size()).require_inside(stands, 1500.0); });
  };
  EXPECT_EQ(refused(Eigen::Vector2d(2.7, -0.7)), "");
  EXPECT_NE(refused(Eigen::Vector2d(2.7, 0.0)).find("actuator 0 to 2.7"), std::string::npos);
  EXPECT_EQ(refused(VectorXd::Constant(1, 2.7)), "");
}

// The loop of a run: update, PID, commit.
TEST_F(ArmRun, ACycleDoesNotAllocate) {
  if (dvrk_malloc_count() < 0) GTEST_SKIP() << "the sanitizer has a malloc of its own";
  ArmSession arm(link_, planar_config());
  JointPid pid(sensible_gains(model_), Eigen::Vector2d(10.0, 10.0));
  arm.start();
  const VectorXd wanted = Eigen::Vector2d(0.4, -0.7);
  const VectorXd still = VectorXd::Zero(2);
  VectorXd tau = still;
  const auto cycles = [&](int count) {
    for (int k = 0; k < count; ++k) {
      link_.wait(1.0 / 1500.0);
      if (arm.update()) {
        pid.torques(arm.state().q, arm.state().dq, wanted, still, 1.0 / 1500.0, tau);
        arm.set_torques(tau);
      }
      arm.commit();
    }
  };
  cycles(5);
  ASSERT_EQ(arm.boards().power_on(), nullptr);
  cycles(300);
  ASSERT_EQ(arm.boards().state(), PowerState::kOn);
  const long before = dvrk_malloc_count();
  cycles(300);
  EXPECT_EQ(dvrk_malloc_count(), before);
  EXPECT_EQ(arm.boards().state(), PowerState::kOn);
}

TEST_F(ArmRun, ASignalEndsItWithPowerOff) {
  ArmSession arm(link_, planar_config());
  stop_ = true;
  const RunResult run =
      run_motion(arm, link_, motion(2.0), sensible_gains(model_), RunOptions(), stop_);
  EXPECT_FALSE(run.complete);
  EXPECT_EQ(run.why, "stopped by a signal");
  EXPECT_EQ(run.rows.rows(), 0);
  EXPECT_FALSE(emulator_.board(0).status().power_requested());
}

TEST_F(ArmRun, AFaultOnTheWayEndsItWithItsName) {
  emulator_.board(0).faults.amp[1] = true;  // never comes up
  ArmSession arm(link_, planar_config());
  const RunResult run =
      run_motion(arm, link_, motion(2.0), sensible_gains(model_), RunOptions(), stop_);
  EXPECT_FALSE(run.complete);
  EXPECT_EQ(run.why, describe(Condition::kAmpOff) + std::string(" (board 6, channel 2)"));
  EXPECT_FALSE(emulator_.board(0).amp_on(0));
}

TEST_F(ArmRun, AJointThatDoesNotFollowEndsIt) {
  ArmSession arm(link_, planar_config());
  PidGains weak = sensible_gains(model_);
  weak.p *= 0.01;
  weak.i *= 0.0;
  const RunResult run = run_motion(arm, link_, motion(2.0), weak, RunOptions(), stop_);
  EXPECT_FALSE(run.complete);
  EXPECT_NE(run.why.find("off its set point"), std::string::npos) << run.why;
  EXPECT_FALSE(emulator_.board(0).amp_on(0));
}

TEST_F(ArmRun, RecordsAtRestWithoutPower) {
  ArmSession arm(link_, planar_config());
  const RunResult run = record_at_rest(arm, link_, 0.5, 1000.0, stop_);
  EXPECT_TRUE(run.complete);
  EXPECT_NEAR(run.rows.rows(), 500, 3);
  EXPECT_LT(run.rows.tau.cwiseAbs().maxCoeff(), 0.01);  // half a bit of current
  EXPECT_EQ(run.rows.dq.cwiseAbs().maxCoeff(), 0.0);
  EXPECT_FALSE(emulator_.board(0).status().power_requested());
}

// Nothing is driven, so nothing ends: the recording says that its positions are worth little.
TEST_F(ArmRun, ARecordingTellsThatEncodersFailed) {
  for (const char* fault : {"", "overflow", "transition"}) {
    PlanarArm bench;
    EmulatedEncoder& encoder = bench.emulator.board(0).encoder(1);
    ArmSession arm(bench.link, planar_config());
    arm.start();
    const double at = bench.link.now() + 1.0;
    bench.link.each = [&](double now) {
      encoder.overflow_latched = now > at && std::string(fault) == "overflow";
      encoder.broken_lines = now > at && std::string(fault) == "transition";
    };
    const std::string path = testing::TempDir() + "failed-encoders.csv";
    const RunResult run = record_at_rest(arm, bench.link, 1.5, 1000.0, bench.stop, path);
    EXPECT_TRUE(run.complete) << run.why;
    EXPECT_EQ(run.remark.find("the last of board 6, channel 2: positions") != std::string::npos, *fault != 0) << run.remark;
    EXPECT_EQ(first_line(path).rfind("# encoders failed ", 0) == 0, *fault != 0) << first_line(path);
    std::remove(path.c_str());
  }
}

// The motion begins when the brake is open; until then the arm gets no torque.
TEST_F(ArmRun, ABrakeOpensBeforeTheMotion) {
  RobotConfig robot = planar_config();
  robot.actuators[0].brake =
      BrakeConfig{6, 2, kNominalAmpsToBits, kNominalBitsToAmps, 0.9, 0.9, 0.02, 0.2, 0.0};
  SimulatedArm braked(plant_, robot, MatrixXd(), {6}, Eigen::Vector2d(0.4, -0.7));
  emulator_.attach(&braked);
  ArmSession arm(link_, robot);
  const RunResult run =
      run_motion(arm, link_, motion(4.0), sensible_gains(model_), RunOptions(), stop_);
  EXPECT_TRUE(run.complete) << run.why;
  EXPECT_NEAR(emulator_.board(0).dac(2), 32768, 1);  // engaged again
}

// The supervisor's test of position limits, position plus velocity over 30, is made of the whole
// motion before power comes on: never beyond 2.49 rad of 2.5, but too fast there.
TEST_F(ArmRun, AMotionThatCouldNotStopBeforeALimitIsRefusedBeforePower) {
  ArmSession arm(link_, planar_config());
  const PidGains gains = sensible_gains(model_);
  MotionSamples fast = swinging(4.0, Eigen::Vector2d(1.69, 0.1), 0.8);
  ASSERT_LT(fast.q.maxCoeff(), 2.4901);
  EXPECT_TRUE(refuses_with("--limit-share", [&] { run_motion(arm, link_, fast, gains, RunOptions(), stop_); }));
  EXPECT_EQ(emulator_.counters().writes, 0);
  EXPECT_FALSE(emulator_.board(0).status().power_requested());
  const MotionSamples slower = swinging(8.0, Eigen::Vector2d(1.69, 0.1), 0.74);
  const RunResult run = run_motion(arm, link_, slower, gains, RunOptions(), stop_);
  EXPECT_TRUE(run.complete) << run.why;
}

// With a PID nothing but the soft limits holds an arm that runs away: here it is thrown.
TEST_F(ArmRun, SoftLimitsEndARunWithAPid) {
  bool thrown = false;  // before the session, which waits once more when it ends
  WatchedLink link(emulator_);
  ArmSession arm(link, planar_config());
  link.each = [&](double now) {
    if (thrown || now < 5.0) return;
    thrown = true;
    plant_.set_state(Eigen::Vector2d(0.1, 2.3), Eigen::Vector2d(0.0, 8.0));  // 2.3 + 8/30 > 2.5
  };
  RunOptions options;
  options.largest_error = Eigen::Vector2d(9.0, 9.0);  // not what ends it
  const RunResult run = run_motion(arm, link, motion(8.0), sensible_gains(model_), options, stop_);
  EXPECT_TRUE(thrown);
  EXPECT_FALSE(run.complete);
  EXPECT_NE(run.why.find("actuator 1 leaves its soft limits"), std::string::npos) << run.why;
  EXPECT_EQ(run.power, OffState::kConfirmed);
  EXPECT_FALSE(emulator_.board(0).amp_on(1));
}

TEST_F(ArmRun, AnErrorIsInTheUnitOfItsJoint) {
  RobotConfig robot = planar_config();
  robot.actuators[1].prismatic = true;
  const VectorXd errors = default_largest_errors(robot);
  EXPECT_EQ(errors[0], 0.35);
  EXPECT_EQ(errors[1], 0.02);
  ArmSession arm(link_, planar_config());
  RunOptions options;
  options.largest_error = Eigen::Vector2d(0.35, 1e-6);  // so small that the second joint breaks it
  const RunResult run = run_motion(arm, link_, motion(4.0), sensible_gains(model_), options, stop_);
  EXPECT_FALSE(run.complete);
  EXPECT_NE(run.why.find("joint 2 is"), std::string::npos) << run.why;
}

// Does as it is told, and changes the network when it is first asked for torques.
class ChangesTheNetwork final : public MotionController {
 public:
  explicit ChangesTheNetwork(std::function<void()> change) : change_(std::move(change)) {}
  void reset() noexcept override {}
  bool torques(const BoardArmState&, const JointReference&, const CycleTimes&,
               VectorXd& tau) noexcept override {
    tau.setZero();
    change_();
    return true;
  }
  std::string why() const override { return ""; }
  bool follows() const override { return false; }

 private:
  std::function<void()> change_;
};

// The arm of README's example by a clock of its own: the motors of a nominal PSM1 carry and move it.
TEST(LightArm, MovesOnTheNominalBoardsOfPsm1) {
  const ArmFacts facts = read_arm("PSM1");
  const RobotConfig robot = nominal_config(facts).robot("");
  const Model model = read_model(std::string(VERIDYN_SOURCE_DIR) + "/examples/dvrk/light-psm.yaml");
  MotionSamples way;
  way.time = VectorXd::LinSpaced(41, 0.0, 2.0);
  way.q.resize(41, 3);
  way.dq.resize(41, 3);
  const Eigen::RowVector3d reach(0.9, -0.8, 0.15);
  for (int k = 0; k <= 40; ++k) {
    const double w = M_PI / 2.0, t = way.time[k];
    way.q.row(k) = Eigen::RowVector3d(0.0, 0.0, 0.05) + (0.5 - 0.5 * std::cos(w * t)) * reach;
    way.dq.row(k) = 0.5 * w * std::sin(w * t) * reach;
  }
  PidGains gains{VectorXd::Zero(7), VectorXd::Zero(7), VectorXd::Zero(7)};
  for (int j = 0; j < 7; ++j) {
    gains.p[j] = facts.actuators[j].kp;
    gains.d[j] = facts.actuators[j].kd;
  }
  for (const bool pid : {true, false}) {
    Plant plant(model);
    BoardEmulator emulator(Bench::setups(robot));
    EmulatedLink link(emulator);
    SimulatedArm load(plant, robot, facts.coupling(), boards_of(robot), Eigen::Vector3d(0.0, 0.0, 0.12));
    emulator.attach(&load);
    ArmSessionOptions options;
    options.actuator_to_joint = facts.coupling();
    ArmSession arm(link, robot, options);
    ModelControlOptions law;
    law.law = ControlLaw::kComputedTorque;
    ModelController computed(model, gains, largest_torques(arm), law);
    RunOptions how;
    how.approach_speed = 1.0;
    how.largest_error = default_largest_errors(robot).cwiseMin(0.1);
    const std::atomic<bool> stop{false};
    const RunResult run = pid ? run_motion(arm, link, way, gains, how, stop)
                              : run_motion(arm, link, way, computed, how, stop);
    EXPECT_TRUE(run.complete) << run.why;
    EXPECT_EQ(run.timing.late, 0);
  }
}

// Replies that are 5 ms late: 94 cycles per second in place of 1500.
TEST_F(ArmRun, ALoopThatIsAlwaysLateIsStopped) {
  BadLink link(emulator_);
  ArmSession arm(link, planar_config());
  ChangesTheNetwork controller([&] { link.down.delay = 0.005; });
  const RunResult run = run_in_place(arm, link, 8.0, 2, controller, RunOptions(), stop_);
  EXPECT_FALSE(run.complete);
  EXPECT_NE(run.why.find("the loop is late"), std::string::npos) << run.why;
  // Under a sanitizer the boards, emulated in this program, work for longer than their replies take.
  const bool sanitized = dvrk_malloc_count() < 0;
  EXPECT_TRUE(sanitized || run.why.find("replies took") != std::string::npos) << run.why;
  EXPECT_EQ(run.power, OffState::kConfirmed);
  EXPECT_LT(link.now(), 3.0);
}

// The same from the start: nothing is powered, and the first thing said is why.
TEST_F(ArmRun, AMachineThatIsTooBusyIsSaidBeforePower) {
  BadLink link(emulator_);
  ArmSession arm(link, planar_config());
  link.down.delay = 0.005;
  bool powered = false;
  ChangesTheNetwork controller([&] { powered = true; });
  const RunResult run = run_in_place(arm, link, 1.0, 2, controller, RunOptions(), stop_);
  EXPECT_FALSE(run.complete);
  EXPECT_FALSE(powered);
  EXPECT_NE(run.why.find("too busy"), std::string::npos) << run.why;
  EXPECT_NE(run.why.find("Nothing was moved"), std::string::npos) << run.why;
  EXPECT_EQ(run.power, OffState::kConfirmed);
}

// A stall before power is waited for.
TEST_F(ArmRun, AStallBeforePowerIsWaitedFor) {
  BadLink link(emulator_);
  ArmSession arm(link, planar_config());
  int asked = 0;
  ChangesTheNetwork controller([&] { ++asked; });
  arm.start();
  link.down.lose = 1.0;
  arm.update();  // 20 ms without a reply
  link.down.lose = 0.0;
  const RunResult run = run_in_place(arm, link, 0.2, 2, controller, RunOptions(), stop_);
  EXPECT_TRUE(run.complete) << run.why;
  EXPECT_GT(asked, 250);
}

// One datagram of a hundred gets lost, both ways: a read is asked for again within a millisecond.
// Without that a cycle waits 20 ms for it, and the run does not keep its rate.
TEST_F(ArmRun, OnePercentOfLossIsRiddenThrough) {
  for (const bool again : {true, false}) {
    PlanarArm bench;
    BadLink link(bench.emulator, 7);
    ArmSessionOptions options;
    if (!again) options.repeat_after = 0.0;
    ArmSession arm(link, planar_config(), options);
    const Model model = read_model("planar-2r");
    ModelControlOptions law;
    law.law = ControlLaw::kComputedTorque;
    ModelController control(model, sensible_gains(model), largest_torques(arm), law);
    const MotionSamples way = swinging(4.0, Eigen::Vector2d(-0.4, 1.2), 0.4);
    arm.start();
    link.up.lose = link.down.lose = 0.01;
    RunOptions how;
    how.approach_speed = 1.0;
    RunResult run;
    try {
      run = run_motion(arm, link, way, control, how, bench.stop);
    } catch (const InvalidInput& error) {
      run.why = error.what();  // boards that were not found
    }
    EXPECT_EQ(run.complete, again) << run.why;
    if (again) {
      EXPECT_GT(run.timing.reached(), 0.97 * 1500.0);
    }
  }
}

// Boards whose timestamps stand still: the rows have this program's times, and the file says so.
TEST_F(ArmRun, AClockThatStandsStillIsMarkedInTheRecording) {
  for (const bool stands : {true, false}) {
    PlanarArm bench;
    bench.emulator.board(0).faults.stops_clock = stands;
    ArmSession arm(bench.link, planar_config());
    RunOptions options;
    options.recording = testing::TempDir() + "stopped-clock.csv";
    const RunResult run = run_motion(arm, bench.link, swinging(1.0, Eigen::Vector2d(0.1, 0.1), 0.05),
                                     sensible_gains(read_model("planar-2r")), options, bench.stop);
    ASSERT_TRUE(run.complete) << run.why;
    const Eigen::Index last = run.rows.rows() - 1;
    EXPECT_NEAR(run.rows.time[last], 1.0, 2e-3);
    const std::string first = first_line(options.recording);
    EXPECT_EQ(first.find("# the clock of board 6 stood still") == 0, stands) << first;
    EXPECT_EQ(run.remark.empty(), !stands);
    std::remove(options.recording.c_str());
  }
}

// A pot whose wire is gone reads zero: encoders are not loaded from it, and nothing is driven.
TEST_F(ArmRun, APotAtItsEndRefusesHomingAndPower) {
  emulator_.board(0).faults.pot_wire[1] = true;
  ArmSession arm(link_, planar_config());
  EXPECT_TRUE(refuses_with("pot of actuator 1", [&] { arm.start(); }));
  emulator_.board(0).faults.pot_wire[1] = false;
  link_.wait(0.01);
  arm.start();
  emulator_.board(0).faults.pot_wire[1] = true;
  link_.wait(0.01);
  ASSERT_TRUE(arm.update());
  EXPECT_NE(arm.power_on(), nullptr);
}

TEST_F(ArmRun, AnArmOutsideItsLimitsIsNotDriven) {
  RobotConfig narrow = planar_config();
  narrow.actuators[0].upper = 0.2;  // it stands at 0.4
  ArmSession arm(link_, narrow);
  arm.start();
  ASSERT_TRUE(arm.update());
  ASSERT_EQ(arm.homing().outside_limits, std::vector<int>{0});
  EXPECT_NE(arm.power_on(), nullptr);
  EXPECT_FALSE(emulator_.board(0).status().power_requested());
}

TEST_F(ArmRun, EndStopsHoldAnArmThatIsPushed) {
  load_.set_end_stops(Eigen::Vector2d(-0.5, -0.8), Eigen::Vector2d(0.5, 0.8));
  plant_.set_state(Eigen::Vector2d(0.4, -0.7), Eigen::Vector2d(3.0, -3.0));
  ArmSession arm(link_, planar_config());
  arm.start();
  ASSERT_TRUE(arm.update());
  ASSERT_EQ(arm.power_on(), nullptr);
  for (int k = 0; k < 1500; ++k) {
    link_.wait(1.0 / 1500.0);
    arm.update();
    arm.set_torques(Eigen::Vector2d(60.0, -40.0));
    arm.commit();
    ASSERT_LE(plant_.q()[0], 0.5 + 1e-12);
    ASSERT_GE(plant_.q()[1], -0.8 - 1e-12);
  }
  EXPECT_EQ(plant_.q()[0], 0.5);
  EXPECT_EQ(plant_.dq()[0], 0.0);
}

TEST_F(ArmRun, WhatDoesNotFitIsRefused) {
  ArmSession arm(link_, planar_config());
  MotionSamples three = motion(1.0);
  three.q.conservativeResize(Eigen::NoChange, 3);
  EXPECT_THROW(run_motion(arm, link_, three, sensible_gains(model_), RunOptions(), stop_),
               InvalidInput);
  MotionSamples far = motion(1.0);
  far.q.col(1).array() += 2.5;
  EXPECT_TRUE(refuses_with("takes actuator 1 to 2", [&] { run_motion(arm, link_, far, sensible_gains(model_), RunOptions(), stop_); }));
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  std::vector<std::pair<const char*, RunOptions>> wrong(8);
  for (std::size_t k = 0; k < 2; ++k) wrong[k].first = "positive ones";
  wrong[0].second.largest_error = Eigen::Vector2d(0.3, nan);
  wrong[1].second.largest_error = Eigen::Vector2d(nan, 0.3);
  wrong[2].first = "positive approach speed";
  wrong[2].second.approach_speed = nan;
  for (std::size_t k = 3; k < 6; ++k) wrong[k].first = "expected 0 or more";
  wrong[3].second.approach_time = nan;
  wrong[4].second.settle = -1.0;
  wrong[5].second.power_timeout = 1e300;
  for (std::size_t k = 6; k < 8; ++k) wrong[k].first = "a rate of ";
  wrong[6].second.rate = infinity;
  wrong[7].second.rate = nan;
  for (const auto& [words, options] : wrong)
    EXPECT_TRUE(refuses_with(words, [&, &how = options] { run_motion(arm, link_, motion(1.0), sensible_gains(model_), how, stop_); }));
  RobotConfig other = planar_config();
  other.hardware = "DQLA";
  EXPECT_THROW(ArmSession(link_, other), InvalidInput);
  EXPECT_THROW(SimulatedArm(plant_, planar_config(), MatrixXd(), {5}, Eigen::Vector2d(0, 0)),
               InvalidInput);
}

}  // namespace
}  // namespace veridyn::dvrk
