#include "core/crtk_arm.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "core/lock_free.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plant.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn_ros {
namespace {

using veridyn::Model;
using Kind = Command::Kind;

constexpr double kCycle = 0.001;

const Model& psm() {
  static const Model kArm = veridyn::plausible_model(veridyn::read_model("psm-3dof"), 1).arm;
  return kArm;
}

// A simulated arm under the server, without ROS.
struct Rig {
  Rig() : arm(psm()), plant(psm()) {
    plant.set_state(Eigen::Vector3d(0.1, 0.05, 0.12), Eigen::Vector3d::Zero());
    run(0.01);
  }
  void run(double seconds) {
    for (int k = 0; k < static_cast<int>(seconds / kCycle + 0.5); ++k) {
      tau = arm.update(plant.q(), plant.dq(), 0.0, kCycle);
      ASSERT_EQ(plant.step(tau, kCycle), veridyn::StepStatus::kOk);
      ASSERT_TRUE(tau.allFinite());
    }
  }
  Refusal execute_command(Kind kind, const VectorXd& joints = {}, std::uint64_t client = 1) {
    Command c;
    c.kind = kind;
    c.client = client;
    c.count = static_cast<int>(joints.size());
    for (int i = 0; i < c.count; ++i) c.joints[i] = joints[i];
    return arm.command(c);
  }
  // A stream at 100 Hz to a goal, straight.
  void stream_to(const VectorXd& goal, double seconds) {
    const VectorXd from = plant.q();
    const int count = static_cast<int>(seconds * 100.0);
    for (int k = 1; k <= count; ++k) {
      ASSERT_EQ(execute_command(Kind::kServoJp, from + (goal - from) * k / count), Refusal::kNone);
      run(0.01);
    }
  }
  CrtkArm arm;
  veridyn::Plant plant;
  VectorXd tau;
};

VectorXd near_by() { return Eigen::Vector3d(0.15, 0.0, 0.13); }

// An encoder shows 0.1 rad too much. The server of a model that knows it moves to the true position and
// reports true positions; that of one that does not is off by it.
TEST(CrtkArm, SensorErrorsOfTheModelAreCorrected) {
  veridyn::ModelDescription d = psm().description();
  d.coordinates[1].recorded.position_offset = 0.1;
  const Model slipped(std::move(d));
  const veridyn::JointSensors sensors(slipped);
  for (const bool knows : {true, false}) {
    CrtkArm arm(knows ? slipped : psm());
    veridyn::Plant plant(psm());
    plant.set_state(Eigen::Vector3d(0.1, 0.05, 0.12), Eigen::Vector3d::Zero());
    VectorXd shown = plant.q(), tau;
    const auto run = [&](double seconds) {
      for (int k = 0; k < static_cast<int>(seconds / kCycle + 0.5); ++k) {
        shown = plant.q();
        sensors.add_position_errors(shown);
        tau = arm.update(shown, plant.dq(), 0.0, kCycle);
        ASSERT_EQ(plant.step(tau, kCycle), veridyn::StepStatus::kOk);
      }
    };
    run(0.002);
    Command c;
    c.client = 1;
    c.kind = Kind::kEnable;
    EXPECT_EQ(arm.command(c), Refusal::kNone);
    c.kind = Kind::kMoveJp;
    c.count = 3;
    for (int i = 0; i < 3; ++i) c.joints[i] = near_by()[i];
    EXPECT_EQ(arm.command(c), Refusal::kNone);
    run(4.0);
    const double off = (plant.q() - near_by()).cwiseAbs().maxCoeff();
    EXPECT_NEAR(arm.feedback().q[1], knows ? plant.q()[1] : shown[1], 1e-6);
    if (knows) {
      EXPECT_LT(off, 2e-3);
    } else {
      EXPECT_GT(off, 0.09);
    }
  }
}

TEST(CrtkArm, OperatingStatesFollowTheCrtkStateMachine) {
  Rig rig;
  EXPECT_EQ(rig.arm.state(), OperatingState::kDisabled);
  EXPECT_EQ(rig.execute_command(Kind::kPause), Refusal::kInvalidTransition);
  EXPECT_EQ(rig.execute_command(Kind::kResume), Refusal::kInvalidTransition);
  EXPECT_EQ(rig.execute_command(Kind::kMoveJp, near_by()), Refusal::kNotEnabled);
  EXPECT_EQ(rig.tau.norm(), 0.0);
  EXPECT_EQ(rig.arm.feedback().wrench[2], 0.0);  // brakes carry the arm, there is no external force
  EXPECT_EQ(rig.execute_command(Kind::kEnable), Refusal::kNone);
  EXPECT_EQ(rig.execute_command(Kind::kResume), Refusal::kInvalidTransition);
  EXPECT_EQ(rig.execute_command(Kind::kPause), Refusal::kNone);
  EXPECT_EQ(rig.execute_command(Kind::kEnable), Refusal::kInvalidTransition);
  EXPECT_EQ(rig.execute_command(Kind::kServoJp, near_by()), Refusal::kNotEnabled);
  EXPECT_EQ(rig.execute_command(Kind::kResume), Refusal::kNone);
  EXPECT_EQ(rig.execute_command(Kind::kUnhome), Refusal::kNone);
  EXPECT_EQ(rig.execute_command(Kind::kMoveJp, near_by()), Refusal::kNotHomed);
  EXPECT_EQ(rig.execute_command(Kind::kHome), Refusal::kNone);
  EXPECT_EQ(rig.execute_command(Kind::kDisable), Refusal::kNone);
  rig.run(0.01);
  EXPECT_EQ(rig.tau.norm(), 0.0);
}

TEST(CrtkArm, MoveJpEndsInHoldAtItsGoal) {
  Rig rig;
  rig.execute_command(Kind::kEnable);
  ASSERT_EQ(rig.execute_command(Kind::kMoveJp, near_by()), Refusal::kNone);
  rig.run(0.05);
  EXPECT_TRUE(rig.arm.feedback().busy);
  rig.run(5.0);
  EXPECT_FALSE(rig.arm.feedback().busy);
  EXPECT_EQ(rig.arm.mode(), Mode::kHold);
  EXPECT_LT((rig.plant.q() - near_by()).cwiseAbs().maxCoeff(), 2e-3);
}

// Motors that get their power a second after enable: no motion starts meanwhile, and nothing jumps afterwards.
TEST(CrtkArm, NoMotionStartsBeforeTheMotorsHavePower) {
  Rig rig;
  rig.execute_command(Kind::kEnable);
  VectorXd q = rig.plant.q(), still = VectorXd::Zero(3);
  for (int k = 0; k < 1000; ++k) {  // somebody pushes the arm while brakes slip
    q[0] += 2e-4;
    rig.arm.update(q, still, 0.0, kCycle, false);
  }
  EXPECT_TRUE(rig.arm.feedback().busy);
  EXPECT_EQ(rig.execute_command(Kind::kMoveJp, near_by()), Refusal::kNoPower);
  rig.plant.set_state(q, still);
  rig.run(0.5);
  EXPECT_FALSE(rig.arm.feedback().busy);
  EXPECT_LT((rig.plant.q() - q).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_EQ(rig.execute_command(Kind::kMoveJp, near_by()), Refusal::kNone);
}

// Messages delayed by the network arrive in a burst: the arm follows within its speed limits.
TEST(CrtkArm, ABurstOfDelayedMessagesIsFollowedWithinTheSpeedLimits) {
  Rig rig;
  rig.execute_command(Kind::kEnable);
  rig.run(0.1);
  VectorXd q = rig.plant.q();
  double fastest = 0.0;
  for (int burst = 0; burst < 5; ++burst) {
    for (int k = 0; k < 10; ++k) {
      q[0] -= 0.015;
      ASSERT_EQ(rig.execute_command(Kind::kServoJp, q), Refusal::kNone) << burst;
    }
    for (int k = 0; k < 95; ++k) {
      rig.run(kCycle);
      fastest = std::max(fastest, std::abs(rig.plant.dq()[0]));
    }
  }
  EXPECT_EQ(rig.arm.state(), OperatingState::kEnabled) << veridyn::describe(rig.arm.feedback().fault);
  EXPECT_GT(fastest, 1.3);
  EXPECT_LT(fastest, 1.7);  // 0.8 of 2 rad/s
  EXPECT_EQ(rig.execute_command(Kind::kMoveJp, q), Refusal::kNone);
  rig.run(2.0);
  EXPECT_LT((rig.plant.q() - q).cwiseAbs().maxCoeff(), 2e-3);
}

// move_cp reaches a pose taken from the feedback.
TEST(CrtkArm, MoveCpReachesItsPoseAndRefusesUnreachableOnes) {
  Rig rig;
  rig.execute_command(Kind::kEnable);
  veridyn::TipKinematics tip(psm(), {"tool"});
  tip.update(near_by(), VectorXd::Zero(3));
  Command c;
  c.kind = Kind::kMoveCp;
  for (int i = 0; i < 3; ++i) c.position[i] = tip.position()[i];
  ASSERT_EQ(rig.arm.command(c), Refusal::kNone);
  rig.run(5.0);
  const Feedback& f = rig.arm.feedback();
  EXPECT_LT((Eigen::Vector3d(f.position) - tip.position()).norm(), 1e-3);
  c.position[0] = 50.0;
  EXPECT_EQ(rig.arm.command(c), Refusal::kOutOfReach);
}

// 100 ms without a command: held. 1 s: the arm yields, and a push of a newton moves it.
TEST(CrtkArm, AStoppedStreamIsHeldAfter100MillisecondsAndReleasedAfterOneSecond) {
  Rig rig;
  rig.execute_command(Kind::kEnable);
  rig.stream_to(near_by(), 0.5);
  rig.run(0.08);
  EXPECT_EQ(rig.arm.mode(), Mode::kServo);
  rig.run(0.05);
  EXPECT_EQ(rig.arm.mode(), Mode::kHold);
  EXPECT_EQ(rig.arm.feedback().lost_streams, 1U);
  rig.run(0.3);
  const VectorXd held = rig.plant.q();
  rig.run(0.3);
  EXPECT_LT((rig.plant.q() - held).cwiseAbs().maxCoeff(), 1e-3);
  rig.run(0.5);
  EXPECT_EQ(rig.arm.mode(), Mode::kReleased);
  const VectorXd released = rig.plant.q();
  rig.run(1.0);  // gravity is carried: it does not fall
  EXPECT_LT((rig.plant.q() - released).cwiseAbs().maxCoeff(), 5e-3);
  EXPECT_EQ(rig.execute_command(Kind::kMoveJp, near_by()), Refusal::kNone);
}

TEST(CrtkArm, RejectsInvalidCommandsAndContinues) {
  Rig rig;
  rig.execute_command(Kind::kEnable);
  rig.stream_to(near_by(), 0.5);
  VectorXd q = near_by();
  q[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(rig.execute_command(Kind::kServoJp, q), Refusal::kNotFinite);
  q[1] = 3.0;
  EXPECT_EQ(rig.execute_command(Kind::kServoJp, q), Refusal::kBeyondLimits);
  q = near_by();
  q[0] = -0.6;  // within limits, but a jump
  EXPECT_EQ(rig.execute_command(Kind::kServoJp, q), Refusal::kTooFar);
  EXPECT_EQ(rig.execute_command(Kind::kServoJp, VectorXd::Zero(2)), Refusal::kWrongSize);
  EXPECT_EQ(rig.execute_command(Kind::kServoJf, Eigen::Vector3d(1e4, 0, 0)), Refusal::kBeyondLimits);
  Command old;
  old.kind = Kind::kHold;
  old.age = 3.0;
  EXPECT_EQ(rig.arm.command(old), Refusal::kTooOld);
  old.age = -3.0;  // a clock that jumped
  EXPECT_EQ(rig.arm.command(old), Refusal::kTooOld);
  EXPECT_EQ(rig.arm.feedback().refusals, 7U);
  rig.run(0.05);
  EXPECT_EQ(rig.arm.state(), OperatingState::kEnabled);
  EXPECT_LT((rig.plant.q() - near_by()).cwiseAbs().maxCoeff(), 5e-3);
}

TEST(CrtkArm, OneClientStreamsAtATime) {
  Rig rig;
  rig.execute_command(Kind::kEnable);
  const VectorXd here = rig.plant.q();
  ASSERT_EQ(rig.execute_command(Kind::kServoJp, here, 1), Refusal::kNone);
  rig.run(0.01);
  EXPECT_EQ(rig.execute_command(Kind::kServoJp, here, 2), Refusal::kOtherClient);
  EXPECT_EQ(rig.execute_command(Kind::kServoJp, here, 1), Refusal::kNone);
  EXPECT_EQ(rig.execute_command(Kind::kHold, {}, 2), Refusal::kNone);  // less motion is for everybody
  EXPECT_EQ(rig.execute_command(Kind::kServoJp, here, 2), Refusal::kNone);
}

// A twist moves the tip by velocity times time; efforts come on top of gravity.
TEST(CrtkArm, ATwistMovesTheTipAndZeroEffortHoldsTheArm) {
  Rig rig;
  rig.execute_command(Kind::kEnable);
  rig.run(0.2);
  const Eigen::Vector3d from(rig.arm.feedback().position);
  Command c;
  c.kind = Kind::kServoCv;
  c.client = 1;
  c.six[0] = 0.02;
  for (int k = 0; k < 100; ++k) {
    ASSERT_EQ(rig.arm.command(c), Refusal::kNone);
    rig.run(0.01);
  }
  EXPECT_NEAR(rig.arm.feedback().position[0] - from[0], 0.02, 4e-3);
  const VectorXd before = rig.plant.q();
  for (int k = 0; k < 50; ++k) {
    ASSERT_EQ(rig.execute_command(Kind::kServoJf, VectorXd::Zero(3)), Refusal::kNone);
    rig.run(0.01);
  }
  EXPECT_LT((rig.plant.q() - before).cwiseAbs().maxCoeff(), 2e-2);
}

// Positions that are old, or no numbers, are a fault; the torque stays finite.
TEST(CrtkArm, NonFinitePositionsAreAFaultAndTheTorqueStaysFinite) {
  Rig rig;
  rig.execute_command(Kind::kEnable);
  rig.run(0.1);
  const VectorXd bad = VectorXd::Constant(3, std::numeric_limits<double>::quiet_NaN());
  const VectorXd tau = rig.arm.update(bad, bad, 0.0, kCycle);
  EXPECT_TRUE(tau.allFinite());
  EXPECT_EQ(rig.arm.state(), OperatingState::kFault);
  EXPECT_EQ(rig.execute_command(Kind::kServoJp, near_by()), Refusal::kNotEnabled);
  rig.run(0.05);
  EXPECT_EQ(rig.execute_command(Kind::kEnable), Refusal::kNone);
  EXPECT_EQ(rig.arm.state(), OperatingState::kEnabled);
}

TEST(LockFree, ASnapshotIsReadOnceAndAQueueKeepsItsOrder) {
  Snapshot<int> newest;
  int x = 0;
  EXPECT_FALSE(newest.read(x));
  newest.write(1);
  newest.write(2);
  EXPECT_TRUE(newest.read(x));
  EXPECT_EQ(x, 2);
  EXPECT_FALSE(newest.read(x));
  Queue<int, 2> queue;
  EXPECT_TRUE(queue.push(1));
  EXPECT_TRUE(queue.push(2));
  EXPECT_FALSE(queue.push(3));
  EXPECT_TRUE(queue.pop(x));
  EXPECT_EQ(x, 1);
  EXPECT_TRUE(queue.push(3));
  EXPECT_TRUE(queue.pop(x));
  EXPECT_TRUE(queue.pop(x));
  EXPECT_EQ(x, 3);
  EXPECT_FALSE(queue.pop(x));
}

}  // namespace
}  // namespace veridyn_ros
