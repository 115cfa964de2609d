#include "veridyn/dvrk/arm_run.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "dvrk/planar_arm.hpp"
#include "dvrk/rig.hpp"
#include "veridyn/dvrk/emulated_link.hpp"
#include "veridyn/dvrk/joint_pid.hpp"
#include "veridyn/dvrk/simulated_arm.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/model_file.hpp"
#include "veridyn/simulation/plant.hpp"

// A whole arm in one process: client, boards, motors, encoders, with a clock of its own.

namespace veridyn::dvrk {
namespace {

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
  EXPECT_EQ(run.why, describe(Condition::kAmpOff));
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

// The motion begins when the brake is open; until then the arm gets no torque.
TEST_F(ArmRun, ABrakeOpensBeforeTheMotion) {
  RobotConfig robot = planar_config();
  robot.actuators[0].brake =
      BrakeConfig{6, 2, kNominalAmpsToBits, kNominalBitsToAmps, 0.9, 0.9, 0.02, 0.2, 0.0};
  ArmSession arm(link_, robot);
  const RunResult run =
      run_motion(arm, link_, motion(4.0), sensible_gains(model_), RunOptions(), stop_);
  EXPECT_TRUE(run.complete) << run.why;
  EXPECT_NEAR(emulator_.board(0).dac(2), 32768, 1);  // engaged again
}

TEST_F(ArmRun, WhatDoesNotFitIsRefused) {
  ArmSession arm(link_, planar_config());
  MotionSamples three = motion(1.0);
  three.q.conservativeResize(Eigen::NoChange, 3);
  EXPECT_THROW(run_motion(arm, link_, three, sensible_gains(model_), RunOptions(), stop_),
               InvalidInput);
  MotionSamples far = motion(1.0);
  far.q.col(1).array() += 2.5;
  try {
    run_motion(arm, link_, far, sensible_gains(model_), RunOptions(), stop_);
    ADD_FAILURE() << "beyond the soft limits";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("actuator 1 from 2"), std::string::npos)
        << error.what();
  }
  RobotConfig other = planar_config();
  other.hardware = "DQLA";
  EXPECT_THROW(ArmSession(link_, other), InvalidInput);
  EXPECT_THROW(SimulatedArm(plant_, planar_config(), MatrixXd(), {5}, Eigen::Vector2d(0, 0)),
               InvalidInput);
}

}  // namespace
}  // namespace veridyn::dvrk
