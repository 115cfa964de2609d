#include "dvrk/run/controllers/model_controller.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "dvrk/planar_arm.hpp"
#include "dvrk/rig.hpp"
#include "dvrk/run/arm_run.hpp"
#include "veridyn/math/require.hpp"

// The laws of control/ on an arm session: boards, encoders and motors of planar-2r in one process.

namespace veridyn::dvrk {
namespace {

constexpr double kSeconds = 6.0;
constexpr double kGravity = 9.81;
const Eigen::Vector2d kMiddle(-0.4, 1.2);  // the elbow never stretches
constexpr double kAmplitude = 0.5;

ModelControlOptions law(ControlLaw one) {
  ModelControlOptions options;
  options.law = one;
  return options;
}

// A run of any law; a weightless arm ignores the motion.
struct Trial {
  explicit Trial(ControlLaw one, const Model& believed = read_model("planar-2r"))
      : arm(bench.link, planar_config()),
        model(believed),
        control(model, sensible_gains(model), largest_torques(arm), law(one)),
        in_place(one == ControlLaw::kGravity) {}

  RunResult run() {
    const RunOptions options;
    return in_place ? run_in_place(arm, bench.link, kSeconds, 2, control, options, bench.stop)
                    : run_motion(arm, bench.link, motion, control, options, bench.stop);
  }

  PlanarArm bench;
  ArmSession arm;
  Model model;
  ModelController control;
  bool in_place;
  MotionSamples motion = swinging(kSeconds, kMiddle, kAmplitude);
};

Eigen::Vector2d wanted(double t) {
  const double w = 2.0 * M_PI / kSeconds;
  return kMiddle - kAmplitude * Eigen::Vector2d(std::cos(2 * w * t), std::cos(3 * w * t));
}

// Closed forms for data/robots/planar-2r.yaml: rods of 0.5 m and 0.4 m, 4 kg and 2.5 kg.
Eigen::Vector2d tip(const Eigen::Vector2d& q) {
  const double both = q[0] + q[1];
  return {0.5 * std::cos(q[0]) + 0.4 * std::cos(both), 0.5 * std::sin(q[0]) + 0.4 * std::sin(both)};
}
Eigen::Vector2d gravity_torque(const Eigen::Vector2d& q) {
  const double fore = 2.5 * kGravity * 0.2 * std::cos(q[0] + q[1]);
  return {kGravity * (4.0 * 0.25 + 2.5 * 0.5) * std::cos(q[0]) + fore, fore};
}

double worst_joint_error(const Recording& rows) {
  double worst = 0.0;
  for (int k = 0; k < rows.rows(); ++k) {
    const Eigen::Vector2d off = rows.q.row(k).transpose() - wanted(rows.time[k]);
    worst = std::max(worst, off.cwiseAbs().maxCoeff());
  }
  return worst;
}

double worst_tip_error(const Recording& rows) {
  double worst = 0.0;
  for (int k = 0; k < rows.rows(); ++k)
    worst = std::max(worst, (tip(rows.q.row(k).transpose()) - tip(wanted(rows.time[k]))).norm());
  return worst;
}

TEST(ModelController, ComputedTorqueFollowsTheJoints) {
  Trial trial(ControlLaw::kComputedTorque);
  const RunResult run = trial.run();
  ASSERT_TRUE(run.complete) << run.why << "\n" << trial.arm.boards().faults().report();
  EXPECT_NEAR(run.rows.rows(), kSeconds * 1500, 20);
  EXPECT_LT(worst_joint_error(run.rows), 0.01);
  EXPECT_GT(worst_joint_error(run.rows), 1e-6);
  EXPECT_FALSE(trial.bench.emulator.board(0).status().power_requested());
  EXPECT_FALSE(trial.bench.currents_flow());
}

TEST(ModelController, ImpedanceFollowsTheTip) {
  Trial trial(ControlLaw::kImpedance);
  const RunResult run = trial.run();
  ASSERT_TRUE(run.complete) << run.why << "\n" << trial.arm.boards().faults().report();
  EXPECT_LT(worst_tip_error(run.rows), 0.004);  // [m]
  EXPECT_FALSE(trial.bench.currents_flow());
}

// Weightless: it stays where it was, under the torque of gravity at that place, in closed form.
TEST(ModelController, GravityCompensationHoldsTheArm) {
  Trial trial(ControlLaw::kGravity);
  const RunResult run = trial.run();
  ASSERT_TRUE(run.complete) << run.why << "\n" << trial.arm.boards().faults().report();
  EXPECT_NEAR(run.rows.rows(), kSeconds * 1500, 20);
  const Eigen::Vector2d start(0.4, -0.7);
  for (int k = 0; k < run.rows.rows(); k += 100) {
    const Eigen::Vector2d q = run.rows.q.row(k), tau = run.rows.tau.row(k);
    ASSERT_LT((q - start).cwiseAbs().maxCoeff(), 1e-3);
    ASSERT_LT((tau - gravity_torque(q)).cwiseAbs().maxCoeff(), 0.01);  // three bits of current
  }
}

// planar-2r with a shoulder encoder that shows 0.1 rad too much, and drives there that give less than
// is commanded.
Model with_wrong_shoulder() {
  ModelDescription d = read_model("planar-2r").description();
  d.coordinates[0].recorded.position_offset = 0.1;
  d.coordinates[0].recorded.torque_gain = 1.1;
  return Model(std::move(d));
}

// True positions of the joints; rows are as the boards show them.
Recording true_rows(Recording rows) {
  rows.q.col(0).array() -= 0.1;
  return rows;
}

// A motion is led in true positions by a model that knows its sensors, as well as without errors; by
// one that does not, it is off by the zero.
TEST(ModelController, AnEncoderZeroInTheModelIsCorrectedInTheMotion) {
  Trial plain(ControlLaw::kComputedTorque);
  const double usual = worst_joint_error(plain.run().rows);
  for (const bool knows : {true, false}) {
    Trial trial(ControlLaw::kComputedTorque,
                knows ? with_wrong_shoulder() : read_model("planar-2r"));
    trial.bench.load.set_sensors(JointSensors(with_wrong_shoulder()));
    const RunResult run = trial.run();
    ASSERT_TRUE(run.complete) << run.why << "\n" << trial.arm.boards().faults().report();
    const double worst = worst_joint_error(true_rows(run.rows));
    if (knows) {
      EXPECT_LT(worst, 1.5 * usual);
    } else {
      EXPECT_GT(worst, 0.09);
    }
  }
}

// The torque of gravity at the true place, as the drives count it; without that the arm sinks.
TEST(ModelController, GravityCompensationHoldsAnArmWhoseSensorErrorsAreModelled) {
  for (const bool knows : {true, false}) {
    Trial trial(ControlLaw::kGravity, knows ? with_wrong_shoulder() : read_model("planar-2r"));
    trial.bench.load.set_sensors(JointSensors(with_wrong_shoulder()));
    const RunResult run = trial.run();
    const Recording rows = true_rows(run.rows);
    const Eigen::Vector2d start(0.4, -0.7);
    const double moved = (rows.q.rowwise() - start.transpose()).cwiseAbs().maxCoeff();
    if (knows) {
      EXPECT_TRUE(run.complete) << run.why;
      EXPECT_LT(moved, 1e-3);
      EXPECT_NEAR(rows.tau(1000, 0), 1.1 * gravity_torque(start)[0], 0.02);
    } else {
      EXPECT_GT(moved, 0.05);
    }
  }
}

// Everything from one cycle to the next: link, boards, controller, rows.
TEST(ModelController, ACycleOfARunDoesNotAllocate) {
  if (dvrk_malloc_count() < 0) GTEST_SKIP() << "the sanitizer has a malloc of its own";
  for (const ControlLaw one :
       {ControlLaw::kComputedTorque, ControlLaw::kImpedance, ControlLaw::kGravity}) {
    long first = -1, last = -1;
    Trial trial(one);
    trial.bench.link.each = [&](double now) {
      if (!trial.bench.currents_flow()) return;
      if (first < 0 && now > 4.0) first = dvrk_malloc_count();  // after the approach
      if (now < 6.0) last = dvrk_malloc_count();
    };
    EXPECT_TRUE(trial.run().complete);
    EXPECT_GE(first, 0);
    EXPECT_EQ(first, last);
  }
}

TEST(ModelController, AnEmergencyStopEndsEveryLawWithoutCurrents) {
  for (const ControlLaw one :
       {ControlLaw::kComputedTorque, ControlLaw::kImpedance, ControlLaw::kGravity}) {
    bool flowed = false;
    Trial trial(one);
    trial.bench.link.each = [&](double now) {
      if (now < 5.0) flowed = flowed || trial.bench.currents_flow();
      if (now > 5.0) trial.bench.emulator.chain.emergency_stop = true;
    };
    const RunResult run = trial.run();
    EXPECT_FALSE(run.complete);
    EXPECT_NE(run.why, "");
    EXPECT_TRUE(flowed);
    EXPECT_LT(run.rows.rows(), 1500 * kSeconds * 0.8);
    EXPECT_FALSE(trial.bench.currents_flow());
    EXPECT_FALSE(trial.bench.emulator.board(0).amp_on(0));
    EXPECT_FALSE(trial.bench.emulator.board(0).status().power_requested());
  }
}

// All replies are lost: the session gives up, and the watchdog opens the amplifiers.
TEST(ModelController, ALostBoardEndsEveryLawWithoutCurrents) {
  for (const ControlLaw one :
       {ControlLaw::kComputedTorque, ControlLaw::kImpedance, ControlLaw::kGravity}) {
    Trial trial(one);
    trial.bench.link.each = [&](double now) {
      if (now < 5.0) return;
      trial.bench.emulator.faults.reply = ReplyFault::kDrop;
      trial.bench.emulator.faults.replies = -1;
    };
    const RunResult run = trial.run();
    EXPECT_FALSE(run.complete);
    EXPECT_NE(run.why, "");
    trial.bench.link.each = nullptr;
    trial.bench.link.wait(0.1);
    EXPECT_FALSE(trial.bench.emulator.board(0).amp_on(0));
    EXPECT_FALSE(trial.bench.emulator.board(0).amp_on(1));
    EXPECT_FALSE(trial.bench.currents_flow());
  }
}

// The arm is thrown: the supervisor's velocity limit ends the run, with its name and the joint's.
TEST(ModelController, AVelocityBeyondTheSupervisorsLimitEndsTheRunWithItsJoint) {
  bool thrown = false;
  int cycles = 0;  // with currents, since
  Trial trial(ControlLaw::kGravity);
  trial.bench.link.each = [&](double now) {
    if (thrown) cycles += trial.bench.currents_flow() ? 1 : 0;
    if (thrown || now < 5.0) return;
    trial.bench.plant.set_state(trial.bench.plant.q(), Eigen::Vector2d(0.0, 6.0));
    thrown = true;
  };
  const RunResult run = trial.run();
  EXPECT_FALSE(run.complete);
  EXPECT_LE(cycles, 2);  // velocities come from encoder edges, a cycle late
  EXPECT_EQ(run.why, "safety supervisor: a velocity limit (joint elbow)");
  EXPECT_FALSE(trial.bench.currents_flow());
  EXPECT_FALSE(trial.bench.emulator.board(0).amp_on(1));
}

TEST(ModelController, InvalidOptionsAreRefused) {
  const Model model = read_model("planar-2r");
  const PidGains gains = sensible_gains(model);
  EXPECT_THROW(ModelController(read_model("psm-3dof"), gains, Eigen::Vector2d(9, 9)), InvalidInput);
  ModelControlOptions soft;
  soft.stiffness = 0.0;
  EXPECT_THROW(ModelController(model, gains, Eigen::Vector2d(9, 9), soft), InvalidInput);
  ModelControlOptions lost;
  lost.tip = "nowhere";
  EXPECT_THROW(ModelController(model, gains, Eigen::Vector2d(9, 9), lost), InvalidInput);
  Trial fast(ControlLaw::kComputedTorque);
  fast.motion.dq *= 3.0;
  EXPECT_THROW(fast.run(), InvalidInput);
  EXPECT_FALSE(fast.bench.emulator.board(0).status().power_requested());
  Trial stretched(ControlLaw::kImpedance);
  stretched.motion = swinging(kSeconds, {-0.4, 0.3}, kAmplitude);
  EXPECT_THROW(stretched.run(), InvalidInput);
  EXPECT_EQ(default_tip(model), "fore");
  EXPECT_EQ(default_tip(read_model("psm-3dof")), "tool");
}

}  // namespace
}  // namespace veridyn::dvrk
