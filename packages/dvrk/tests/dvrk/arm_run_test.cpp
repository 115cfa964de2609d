#include "dvrk/run/arm_run.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "dvrk/arm_bench.hpp"
#include "dvrk/planar_run.hpp"
#include "dvrk/run/controllers/model_controller.hpp"
#include "support/refusal.hpp"

// A whole arm in one process: how its runs end.

namespace veridyn::dvrk {
namespace {

class ArmRun : public PlanarRun {};

TEST_F(ArmRun, EncodersArePreloadedOnceWithThePotPositions) {
  ArmSession arm(link_, planar_config());
  arm.start();
  EXPECT_TRUE(arm.preloaded());
  ASSERT_TRUE(arm.update());
  EXPECT_NEAR(arm.state().q[0], 0.4, 1e-4);  // one bit of a pot: 8e-5
  EXPECT_NEAR(arm.state().q[1], -0.7, 1e-4);
  arm.start();
  EXPECT_FALSE(arm.preloaded());  // they have theirs
}

TEST_F(ArmRun, ASignalEndsTheRunWithPowerOff) {
  ArmSession arm(link_, planar_config());
  stop_ = true;
  const RunResult run =
      run_motion(arm, link_, motion(2.0), sensible_gains(model_), RunOptions(), stop_);
  EXPECT_FALSE(run.complete);
  EXPECT_EQ(run.why, "stopped by a signal");
  EXPECT_EQ(run.rows.rows(), 0);
  EXPECT_FALSE(emulator_.board(0).status().power_requested());
}

TEST_F(ArmRun, AnAmplifierFaultEndsTheRunAndIsNamedWithItsChannel) {
  emulator_.board(0).faults.amp[1] = true;  // never comes up
  ArmSession arm(link_, planar_config());
  const RunResult run =
      run_motion(arm, link_, motion(2.0), sensible_gains(model_), RunOptions(), stop_);
  EXPECT_FALSE(run.complete);
  EXPECT_EQ(run.why, describe(Condition::kAmpOff) + std::string(" (board 6, channel 2)"));
  EXPECT_FALSE(emulator_.board(0).amp_on(0));
}

TEST_F(ArmRun, ATrackingErrorEndsTheRun) {
  ArmSession arm(link_, planar_config());
  PidGains weak = sensible_gains(model_);
  weak.p *= 0.01;
  weak.i *= 0.0;
  const RunResult run = run_motion(arm, link_, motion(2.0), weak, RunOptions(), stop_);
  EXPECT_FALSE(run.complete);
  EXPECT_NE(run.why.find("off its set point"), std::string::npos) << run.why;
  EXPECT_FALSE(emulator_.board(0).amp_on(0));
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

TEST_F(ArmRun, TrackingErrorLimitsDependOnTheJointType) {
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

// The arm of README's example by a clock of its own: the motors of a nominal PSM1 carry and move it.
TEST(LightArm, IsMovedByTheMotorsOfANominalPsm1) {
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

TEST_F(ArmRun, AMotionThatDoesNotFitTheArmIsRefused) {
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
