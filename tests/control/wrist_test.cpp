#include <gtest/gtest.h>

#include <algorithm>

#include "control/arm_rig.hpp"
#include "support/near.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/control/impedance.hpp"
#include "veridyn/control/model_error_observer.hpp"
#include "veridyn/control/quintic_interpolator.hpp"
#include "veridyn/control/torque_uncertainty.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn {
namespace {

// The whole wrist: six coordinates of the first jaw by impedance in motor coordinates, coupled
// friction, 10 % error everywhere. The seventh motor, which the task leaves free, holds the jaws.
TEST(Wrist, PoseImpedanceMovesTheTipAndHoldsTheRemainingJoint) {
  const Model real = plausible_model(read_model("psm-wrist"), 1).arm;
  const Model wrong = with_wrong_parameters(real, 0.1, 2);
  const Tip tip{"yaw1"};
  ArmRig rig(real, tip);
  VectorXd start(7);
  start << 0.1, 0.05, 0.15, 0.2, 0.3, -0.2, 0.1;
  rig.place(start);
  ArmState state(wrong, tip);
  FrictionOptions rule;
  rule.rule = FrictionRule::kPresliding;
  FrictionCompensation friction(wrong, rule);
  TorqueUncertainty uncertainty(wrong);
  ModelErrorObserver error(7, {10.0, VectorXd::Zero(7)});
  ImpedanceGains gains;
  gains.mass << 0.35, 0.36, 0.3, 0.01, 0.01, 0.01;
  gains.damping << 3, 3, 3, 0.2, 0.2, 0.2;
  gains.stiffness << 15, 15, 15, 1, 1, 1;
  ImpedanceOptions options;
  options.rows = TaskRows::kPose;
  options.home = rig.tip().rotation();
  options.posture = start;
  Impedance control(wrong, tip, gains, options);
  AnalyticalTask task(7, TaskRows::kPose, options.home);
  task.update(rig.tip());
  VectorXd goal = task.x();
  QuinticInterpolator way(goal);
  TaskReference wanted;
  VectorXd tau(7);
  for (int step = 0; step < 6; ++step) {
    goal[step] += step < 3 ? 0.005 : 0.1;
    ASSERT_TRUE(way.move_to(goal, 1.0));
    for (int k = 0; k < 3000; ++k) {
      way.advance(kPeriod);
      wanted.x = way.x();
      wanted.dx = way.dx();
      wanted.ddx = way.ddx();
      state.update(rig.q(), rig.dq());
      tau = control.update(state, wanted, rig.wrench());
      tau += friction.update(state, control.joint_velocity(), control.joint_error(), kPeriod);
      error.set_limit(uncertainty.update(state, control.acceleration()));
      tau += error.update(state, control.acceleration(), kPeriod);
      ASSERT_EQ(rig.cycle(tau), StepStatus::kOk);
    }
    task.update(rig.tip());
    const Vector6d e = task.difference(Vector6d(goal)).cwiseAbs();
    EXPECT_LT(e.head<3>().maxCoeff(), 0.0005) << step;
    EXPECT_LT(e.tail<3>().maxCoeff(), 0.02) << step;
    EXPECT_NEAR(rig.engine().q()[6], start[6], 0.01) << step;
  }
}

}  // namespace
}  // namespace veridyn
