#include <gtest/gtest.h>

#include <cmath>

#include "control/control_support.hpp"
#include "control/psm_like.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/control/gravity_compensation.hpp"
#include "veridyn/control/model_error_observer.hpp"
#include "veridyn/control/momentum_observer.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/simulation/plant.hpp"

namespace veridyn {
namespace {

// A torque that the model does not know, on an arm in motion: d(t) = unknown (1 - exp(-b t)),
// whatever acceleration is asked for meanwhile.
TEST(ModelErrorObserver, EstimatesTheModelErrorWithAFirstOrderLag) {
  for (const char* name : {"spherical_RRP", "elbow_6R", "parallelogram"}) {
    const Model& arm = sample_arms().at(name);
    const int n = arm.joints();
    const double dt = 2e-4;
    const double bandwidth = 20.0;
    ArmState state(arm, {last_frame(arm)});
    ModelErrorObserver error(n, {bandwidth, VectorXd::Constant(n, 100.0)});
    Plant plant(arm);
    Random random(12);
    const VectorXd unknown = random.vector(n, -3, 3);
    plant.set_state(random.vector(n, -1, 1), random.vector(n, -0.3, 0.3));
    VectorXd y(n);
    VectorXd tau(n);
    for (int k = 0; k <= 1500; ++k) {
      const double t = dt * k;
      state.update(plant.q(), plant.dq());
      y = 0.5 * std::sin(9.0 * t) * VectorXd::Ones(n) - 2.0 * plant.dq();
      tau = state.bias() + state.mass_matrix() * y + error.update(state, y, dt) - unknown;
      if (k % 300 == 0) {
        const VectorXd expected = (1.0 - std::exp(-bandwidth * t)) * unknown;
        EXPECT_TRUE(near(error.torque(), expected, 0.02 * (0.1 + unknown.norm()))) << name << k;
      }
      ASSERT_EQ(plant.step(tau, dt), StepStatus::kOk);
    }
    error.reset();
    EXPECT_EQ(error.update(state, y, dt).norm(), 0.0);
  }
}

// A motor that gives half of what is asked for is no error of the model: nothing winds up, and when
// the motor is free again d is there at once. Not told, the observer takes it for one.
TEST(ModelErrorObserver, TorqueThatTheMotorsDidNotReceiveIsNoModelError) {
  const Model& arm = sample_arms().at("spherical_RRP");
  const double dt = 5e-4;
  for (const bool told : {true, false}) {
    ArmState state(arm, {last_frame(arm)});
    ModelErrorObserver error(3, {20.0, VectorXd::Constant(3, 100.0)});
    Plant plant(arm);
    plant.set_state(Eigen::Vector3d(0.1, 0.2, 0.3), VectorXd::Zero(3));
    const VectorXd unknown = Eigen::Vector3d(0.2, -0.1, 0.3);
    VectorXd y(3), tau(3), sent(3);
    double most = 0.0;
    for (int k = 0; k < 1200; ++k) {
      state.update(plant.q(), plant.dq());
      y = Eigen::Vector3d(4.0, -4.0, 2.0) * (k > 400 && k < 600 ? 1.0 : 0.0) - 3.0 * plant.dq();
      tau = state.bias() + state.mass_matrix() * y + error.update(state, y, dt);
      sent = tau;
      if (k > 400 && k < 600) sent = state.bias() + 0.5 * (tau - state.bias());
      if (told) error.set_sent_torques(tau, sent);
      if (k > 400 && k < 600) most = std::max(most, (error.torque() - unknown).norm());
      ASSERT_EQ(plant.step(sent - unknown, dt), StepStatus::kOk);
    }
    if (told) {
      EXPECT_LT(most, 0.1) << "wound up";
    } else {
      EXPECT_GT(most, 0.25);
    }
  }
}

// Where less was sent than asked for, the estimate grows no further that way.
TEST(ModelErrorObserver, DoesNotWindUpOnASaturatedMotor) {
  const Model& arm = sample_arms().at("spherical_RRP");
  ArmState state(arm, {last_frame(arm)});
  state.update(Eigen::Vector3d(0.1, 0.2, 0.3), Eigen::Vector3d::Zero());
  ModelErrorObserver error(3, {10.0, VectorXd::Constant(3, 100.0)});
  const VectorXd y = Eigen::Vector3d(5, 5, 5), asked = Eigen::Vector3d(2, 2, 2);
  const VectorXd sent = Eigen::Vector3d(1.99, 2, 2);
  for (int k = 0; k < 100; ++k) {
    error.update(state, y, 1e-3);
    error.set_sent_torques(asked, sent);
  }
  EXPECT_LE(error.torque()[0], 0.0);
  EXPECT_GT(error.torque()[1], 0.1);
}

TEST(ModelErrorObserver, NeverAddsMoreThanItsLimit) {
  const Model& arm = sample_arms().at("spherical_RRP");
  ArmState state(arm, {last_frame(arm)});
  state.update(Eigen::Vector3d(0.1, 0.2, 0.3), Eigen::Vector3d::Zero());
  ModelErrorObserver error(3, {10.0, Eigen::Vector3d(0.5, 0.2, 0.0)});
  const VectorXd y = Eigen::Vector3d(5, -5, 5);
  for (int k = 0; k < 2000; ++k) error.update(state, y, 1e-3);
  EXPECT_LE((error.torque().cwiseAbs() - Eigen::Vector3d(0.5, 0.2, 0.0)).maxCoeff(), 0.0);
  EXPECT_TRUE(error.set_limit(Eigen::Vector3d(0.1, 0.1, 0.1)));
  error.update(state, y, 1e-3);
  EXPECT_LE(error.torque().cwiseAbs().maxCoeff(), 0.1);
  EXPECT_FALSE(error.set_limit(Eigen::Vector3d(0.1, NAN, 0.1)));
  EXPECT_FALSE(error.set_limit(Eigen::Vector2d(0.1, 0.1)));
  EXPECT_THROW(ModelErrorObserver(3, {10.0, VectorXd::Ones(2)}), InvalidInput);
  EXPECT_THROW(ModelErrorObserver(3, {0.0, VectorXd::Ones(3)}), InvalidInput);
}

// One cycle that is no number leaves no trace in what remembers.
TEST(ControllersWithState, GiveFiniteOutputsAfterANonFiniteCycle) {
  const Model arm = psm_like();
  const Tip tip{"tool"};
  ArmState state(arm, tip);
  FrictionOptions options;
  options.rule = FrictionRule::kPresliding;
  FrictionCompensation friction(arm, options);
  ModelErrorObserver error(3, {10.0, VectorXd::Ones(3)});
  MomentumObserver momentum(arm, tip);
  const VectorXd y = Eigen::Vector3d(0.1, -0.1, 0.1);
  const VectorXd none = VectorXd::Zero(3);
  VectorXd q = Eigen::Vector3d(0.1, 0.2, 0.1);
  VectorXd dq = Eigen::Vector3d(0.1, 0.1, 0.05);
  for (int k = 0; k < 100; ++k) {
    q += 1e-3 * dq;
    const bool lost = k == 50;
    state.update(lost ? VectorXd::Constant(3, NAN) : q, dq);
    const VectorXd f = friction.update(state, dq, none, 1e-3);
    const VectorXd d = error.update(state, y, 1e-3);
    const VectorXd r = momentum.update(state, lost ? none : state.bias(), y, 1e-3);
    EXPECT_TRUE(f.allFinite() && d.allFinite() && r.allFinite()) << k;
    EXPECT_EQ(f.norm() > 0.0, !lost) << k;
    EXPECT_EQ(std::isfinite(friction.tank_level(0)), true);
  }
  EXPECT_LT(momentum.torque().norm(), 1.0);
}

// Each input alone that is no number leaves d as it is, and the change of velocity across the gap unused.
TEST(ModelErrorObserver, KeepsItsEstimateInANonFiniteCycle) {
  const Model arm = psm_like();
  const VectorXd q = Eigen::Vector3d(0.1, 0.2, 0.1), dq = Eigen::Vector3d(0.1, 0.1, 0.05);
  const VectorXd y = Eigen::Vector3d(0.1, -0.1, 0.1), none = VectorXd::Constant(3, NAN);
  for (const int lost : {0, 1, 2, 3}) {
    ArmState state(arm, {"tool"});
    ModelErrorObserver error(3, {10.0, VectorXd::Ones(3)});
    for (int k = 0; k < 2; ++k) {
      state.update(q, dq);
      error.update(state, y, 1e-3);
    }
    // The whole error of one cycle: y dt - d(dq) = y dt here, as a torque of M y.
    EXPECT_TRUE(near(error.missing(), state.mass_matrix() * y, 1e-12));
    const VectorXd known = error.torque();
    EXPECT_GT(known.norm(), 0.0);
    state.update(lost == 0 ? none : q, lost == 1 ? none : dq);
    error.update(state, lost == 2 ? none : y, lost == 3 ? static_cast<double>(NAN) : 1e-3);
    EXPECT_EQ(error.torque(), known) << lost;
    state.update(q, 2.0 * dq);
    EXPECT_EQ(error.update(state, y, 1e-3), known) << lost;
  }
}

// With springs and offsets in the model an arm stays where it is let go.
TEST(GravityCompensation, AReleasedArmDoesNotMove) {
  const Model bare = sample_arms().at("coupled_wrist");
  const Model arm = with_effects(bare, {effect_on(bare, "joint_spring", 1, {{"stiffness", 3.0}}),
                                        effect_on(bare, "torque_offset", 0, {{"offset", 0.4}})});
  GravityCompensation gravity(arm);
  Plant plant(arm);
  VectorXd ddq(arm.joints());
  for (const State& s : test_states(arm.joints(), 55)) {
    plant.set_state(s.q, VectorXd::Zero(arm.joints()));
    ASSERT_EQ(plant.accelerate(gravity.update(s.q), ddq), StepStatus::kOk);
    EXPECT_LT(ddq.norm(), 1e-8);
  }
  EXPECT_THROW(GravityCompensation(with_effects(bare, {effect_on(bare, "joint_spring", 0, {})})),
               InvalidInput);
}

}  // namespace
}  // namespace veridyn
