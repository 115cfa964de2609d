#include <gtest/gtest.h>

#include <vector>

#include "control/control_support.hpp"
#include "support/malloc_count.hpp"
#include "veridyn/control/adaptive_friction.hpp"
#include "veridyn/control/computed_torque.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/control/gravity_compensation.hpp"
#include "veridyn/control/impedance.hpp"
#include "veridyn/control/inverse_kinematics.hpp"
#include "veridyn/control/model_error_observer.hpp"
#include "veridyn/control/momentum_observer.hpp"
#include "veridyn/control/quintic_interpolator.hpp"
#include "veridyn/control/safety_supervisor.hpp"
#include "veridyn/control/velocity_observer.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn {
namespace {

struct Cycle {
  VectorXd q, dq;
  Vector6d x, wrench;
};

std::vector<Cycle> cycles(int joints) {
  Random random(71);
  std::vector<Cycle> all;
  for (int k = 0; k < 200; ++k) {
    all.push_back({random.vector(joints, -1, 1), random.vector(joints, -1, 1),
                   random.vector(6, -0.3, 0.3), random.vector(6, -3, 3)});
  }
  return all;
}

template <typename Update>
void expect_no_allocation(const char* what, int joints, const Update& update) {
  const std::vector<Cycle> all = cycles(joints);
  const long before = malloc_count();
  for (const Cycle& cycle : all) update(cycle);
  EXPECT_EQ(malloc_count(), before) << what;
}

TEST(Allocation, NoUpdateAllocates) {
  if (VERIDYN_COUNTS_MALLOC == 0) GTEST_SKIP() << "the sanitizer has a malloc of its own";
  const Model arm = plausible_model(read_model("psm-wrist"), 1).arm;
  const int n = arm.joints();
  const Tip tip{"yaw1"};
  ArmState state(arm, tip);
  const auto at = [&](const Cycle& c) { state.update(c.q, c.dq); };
  expect_no_allocation("ArmState", n, at);

  const VectorXd ones = VectorXd::Ones(n);
  ComputedTorque computed(n, {ones, ones});
  JointReference wanted(n);
  expect_no_allocation("ComputedTorque", n, [&](const Cycle& c) {
    at(c);
    wanted.q = c.dq;
    computed.update(state, wanted);
  });

  for (const TaskRows rows : {TaskRows::kPosition, TaskRows::kPose}) {
    ImpedanceOptions options;
    options.rows = rows;
    options.posture = VectorXd::Zero(n);
    Impedance impedance(arm, tip, {}, options);
    TaskReference task;
    expect_no_allocation("Impedance", n, [&](const Cycle& c) {
      at(c);
      task.x = c.x;
      impedance.update(state, task, c.wrench);
      impedance.set_gains(impedance.gains());
    });

    InverseKinematicsOptions inverse_options;
    inverse_options.rows = rows;
    InverseKinematics inverse(arm, tip, inverse_options);
    VectorXd q = VectorXd::Zero(n);
    expect_no_allocation("InverseKinematics", n, [&](const Cycle& c) {
      inverse.solve(c.x.head<3>(), state.tip().rotation(), q);
    });
  }

  FrictionCompensation friction(arm);
  AdaptiveFrictionOptions adapting;
  adapting.enabled = true;
  AdaptiveFriction adaptive(friction, adapting);
  ModelErrorObserver error(n, {10.0, ones});
  MomentumObserver momentum(arm, tip);
  for (const FrictionRule rule :
       {FrictionRule::kVelocity, FrictionRule::kStickSlip, FrictionRule::kPresliding}) {
    FrictionOptions friction_options;
    friction_options.rule = rule;
    friction = FrictionCompensation(arm, friction_options);
    expect_no_allocation("what makes up for the model", n, [&](const Cycle& c) {
      at(c);
      friction.update(state, c.dq, c.q, 1e-3);
      error.update(state, c.q, 1e-3);
      error.set_limit(ones);
      adaptive.update(state, error.missing(), 1e-3, friction);
      momentum.update(state, c.q, c.dq, 1e-3);
    });
  }

  GravityCompensation gravity(arm);
  VelocityObserver velocity(n);
  expect_no_allocation("filters", n, [&](const Cycle& c) {
    gravity.update(c.q);
    velocity.update(c.q, c.dq, 1e-3);
  });

  SafetySupervisor safety(arm, safety_limits(arm, 10.0));
  safety.enable();
  safety.activate();
  SafetyInput input(n);
  int cycle = 0;
  expect_no_allocation("SafetySupervisor", n, [&](const Cycle& c) {
    at(c);
    if (++cycle % 20 == 0) input.force.setConstant(cycle % 40 == 0 ? NAN : 0.0);
    if (cycle % 10 == 0 && safety.reset() && safety.enable()) safety.activate();
    safety.update(state, input, c.q);
  });

  QuinticInterpolator way(ones);
  expect_no_allocation("QuinticInterpolator", n, [&](const Cycle& c) {
    way.move_to(c.q, 0.5);
    way.advance(0.1);
    way.stop(0.2);
  });
}

}  // namespace
}  // namespace veridyn
