#include <gtest/gtest.h>

#include "simulation/plant_support.hpp"
#include "support/near.hpp"
#include "veridyn/math/require.hpp"

// The plant against an engine that nobody here wrote: M and bias from MuJoCo, another integrator,
// another friction.

namespace veridyn {
namespace {

class PlantAgainstMujoco : public testing::TestWithParam<std::string> {
 protected:
  static Model arm() {
    const auto sample = sample_arms().find(GetParam());
    return sample != sample_arms().end() ? sample->second : robot(GetParam());
  }
};

TEST_P(PlantAgainstMujoco, AccelerationsAgree) {
  const Model model = arm();
  const int n = model.joints();
  Plant plant(model);
  const auto mujoco = make_engine("mujoco", model);
  Random random(31);
  VectorXd ours(n);
  VectorXd theirs(n);
  for (const State& s : test_states(n, 32)) {
    if (s.dq.cwiseAbs().minCoeff() < 1e-3 && !model.effects().empty()) continue;  // dry friction
    const VectorXd tau = random.vector(n, -5, 5);
    plant.set_state(s.q, s.dq);
    mujoco->set_state(s.q, s.dq);
    ASSERT_EQ(plant.accelerate(tau, ours), StepStatus::kOk);
    ASSERT_EQ(mujoco->accelerate(tau, theirs), StepStatus::kOk);
    EXPECT_TRUE(near(ours, theirs, 1e-6 * theirs.norm()));
  }
}

TEST_P(PlantAgainstMujoco, TrajectoriesWithoutFrictionAgree) {
  const Model full = arm();
  std::vector<EffectTerm> kept;
  for (const EffectTerm& term : full.effects()) {
    if (term.effect == "rotor_inertia" || term.effect == "joint_spring") kept.push_back(term);
  }
  const Model model = with_effects(full, kept);
  const int n = model.joints();
  Plant plant(model);
  const auto mujoco = make_engine("mujoco", model);
  const VectorXd start = VectorXd::Constant(n, 0.1);
  const VectorXd zero = VectorXd::Zero(n);
  plant.set_state(start, zero);
  mujoco->set_state(start, zero);
  double range = 0.0;
  double apart = 0.0;
  for (int k = 0; k < 2000; ++k) {
    VectorXd tau(n);
    for (int i = 0; i < n; ++i) tau[i] = 0.2 * std::sin(0.003 * k + i);
    ASSERT_EQ(plant.step(tau, 1e-3), StepStatus::kOk);
    ASSERT_EQ(mujoco->step(tau, 1e-3), StepStatus::kOk);
    range = std::max(range, (plant.q() - start).cwiseAbs().maxCoeff());
    apart = std::max(apart, (plant.q() - mujoco->q()).cwiseAbs().maxCoeff());
    ASSERT_TRUE(near(plant.q(), mujoco->q(), 1e-4 * range + 1e-9)) << k;
  }
  RecordProperty("apart_per_range", text(apart / range));
  EXPECT_GT(range, 0.01);
}

INSTANTIATE_TEST_SUITE_P(Arms, PlantAgainstMujoco,
                         testing::Values("pendulum", "planar_2R", "elbow_6R", "branched_tree",
                                         "parallelogram", "coupled_wrist", "serial_PRPPR",
                                         "psm-3dof", "psm-wrist", "ur10e"),
                         sample_arm_name);

// Friction that decays within a twentieth of the caller's step: m ddq = f - c dq from a speed of 1, in closed form.
TEST(MujocoEngine, FrictionThatDecaysWithinAStepIsStable) {
  const Model bare = slide();
  const double m = mass_of(bare), rate = 2e4, c = rate * m;
  const Model arm = with_effects(bare, {effect(bare, "viscous_friction", 0, {{"coefficient", c}})});
  const auto mujoco = make_engine("mujoco", arm);
  mujoco->set_state(one(0.0), one(1.0));
  const double v = 0.25, dt = 1e-3;
  for (int k = 1; k <= 3; ++k) {
    ASSERT_EQ(mujoco->step(one(c * v), dt), StepStatus::kOk);
    EXPECT_NEAR(mujoco->dq()[0], v, 1e-4);
    EXPECT_NEAR(mujoco->q()[0], v * k * dt + (1.0 - v) / rate, 1e-4 / rate);
    EXPECT_NEAR(mujoco->time(), k * dt, 1e-15);
  }
}

// A caller's long step is made of steps of a millisecond.
TEST(MujocoEngine, ALongStepEqualsStepsOfAMillisecond) {
  const Model arm = sample_arms().at("planar_2R");
  const auto far = make_engine("mujoco", arm), near_by = make_engine("mujoco", arm);
  const VectorXd start = Eigen::Vector2d(0.3, -0.8), speed = Eigen::Vector2d(4.0, -3.0), tau = Eigen::Vector2d(0.5, 0.1);
  far->set_state(start, speed);
  near_by->set_state(start, speed);
  ASSERT_EQ(far->step(tau, 0.2), StepStatus::kOk);
  for (int k = 0; k < 200; ++k) ASSERT_EQ(near_by->step(tau, 1e-3), StepStatus::kOk);
  EXPECT_TRUE(near(far->q(), near_by->q(), 1e-11));
  EXPECT_TRUE(near(far->dq(), near_by->dq(), 1e-10));
}

// Two ways to treat friction, one motion: events and true rest here, a steep sign there.
TEST(PlantAgainstMujocoWithFriction, MotionsAgree) {
  const Model model = robot("psm-3dof");
  Plant plant(model);
  const auto mujoco = make_engine("mujoco", model);
  VectorXd q(3);
  q << 0.1, 0.2, 0.1;
  const VectorXd zero = VectorXd::Zero(3);
  plant.set_state(q, zero);
  mujoco->set_state(q, zero);
  double moved = 0.0;
  for (int k = 0; k < 2000; ++k) {
    for (Engine* engine : {static_cast<Engine*>(&plant), mujoco.get()}) {
      VectorXd tau(3);  // a spring and damper for each joint, through reversals
      for (int i = 0; i < 3; ++i) {
        const double wanted = q[i] + 0.2 * std::sin(0.004 * k + i) * (i == 2 ? 0.2 : 1.0);
        tau[i] = 200.0 * (wanted - engine->q()[i]) - 20.0 * engine->dq()[i];
      }
      ASSERT_EQ(engine->step(tau, 1e-3), StepStatus::kOk);
    }
    moved = std::max(moved, (plant.q() - q).cwiseAbs().maxCoeff());
    ASSERT_TRUE(near(plant.q(), mujoco->q(), 1e-4)) << k;
  }
  EXPECT_GT(moved, 0.1);
}

}  // namespace
}  // namespace veridyn
