#include "veridyn/simulation/plant.hpp"

#include <gtest/gtest.h>

#include "simulation/plant_support.hpp"
#include "support/energy.hpp"
#include "support/malloc_count.hpp"
#include "support/near.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/require.hpp"
#include "simulation/rotors_at_zero.hpp"
#include "support/refusal.hpp"

namespace veridyn {
namespace {

constexpr double kStep = 1e-3;

// Torques that the model's own effects ask for: the classes as identification uses them, their
// memories led along by the caller.
struct InverseDynamics {
  explicit InverseDynamics(const Model& arm) : rigid(arm, *arm.inertial_values()) {
    for (const EffectTerm& term : arm.effects()) effects.emplace_back(arm, term);
  }

  VectorXd operator()(double time, const VectorXd& q, const VectorXd& dq, const VectorXd& ddq) {
    VectorXd tau(q.size());
    rigid.inverse_dynamics(q, dq, ddq, tau);
    const VectorXd load = tau;
    for (BoundEffect& e : effects) {
      AxisSample x = e.sample(time, q.data(), dq.data(), ddq.data(), 1);
      const VectorXd& c = e.term().axis.coefficients;
      x.load = c.dot(load) / c.squaredNorm();
      tau += c * e.force(x);
    }
    return tau;
  }

  RigidBodyDynamics rigid;
  std::vector<BoundEffect> effects;
};

TEST(Plant, InverseDynamicsOfItsMotionReturnTheAppliedTorque) {
  for (const char* name : {"psm-3dof", "psm-wrist"}) {
    Model arm = robot(name);
    std::vector<EffectTerm> effects = arm.effects();
    effects.push_back(
        effect(arm, "presliding_hysteresis", 0, {{"level", 0.1}, {"distance", 5e-3}}));
    effects.push_back(effect(arm, "load_dependent_friction", 1, {{"coefficient", 0.06}}));
    effects.push_back(effect(arm, "stribeck_friction", 2, {{"level", 0.05}, {"velocity", 0.02}}));
    effects.push_back(effect(arm, "position_dependent_viscosity", 1,
                             {{"slope", 0.01}, {"curvature", 0.02}, {"centre", 0.0}}));
    arm = with_effects(arm, effects);
    Plant plant(arm);
    InverseDynamics inverse(arm);
    const VectorXd zero = VectorXd::Zero(arm.joints());
    plant.set_state(zero, zero);
    VectorXd ddq(arm.joints());
    int compared = 0;
    double largest = 0.0;  // of what is not returned
    bool reversed =
        false;  // the joint with a memory: then the samples no longer show its whole path
    for (int k = 0; k < 3000; ++k) {
      const VectorXd tau = swinging_torque(arm.joints(), k * kStep);
      ASSERT_EQ(plant.accelerate(tau, ddq), StepStatus::kOk);
      const VectorXd back = inverse(plant.time(), plant.q(), plant.dq(), ddq);
      // The regularised sign of the effects differs from true friction near rest, by design.
      bool slides = true;
      for (const EffectTerm& term : arm.effects()) {
        slides = slides && std::abs(term.axis.coefficients.dot(plant.dq())) > kRestSpeed;
      }
      reversed = reversed || plant.dq()[0] * plant.q()[0] < 0.0;
      const double size = tau.norm() + inverse_dynamics(arm, plant.q(), plant.dq(), ddq).norm();
      if (slides) {
        ++compared;
        ASSERT_TRUE(near(back.tail(arm.joints() - 1), tau.tail(arm.joints() - 1), 1e-9 * size))
            << name << " at " << plant.time() << " s";
        ASSERT_NEAR(back[0], tau[0], (reversed ? 1e-4 : 1e-9) * size);
      }
      const VectorXd own =
          inverse_dynamics(arm, plant.q(), plant.dq(), ddq) + plant.effect_torques();
      largest = std::max(largest, (own - tau).norm() / size);
      ASSERT_TRUE(near(own, tau, 1e-9 * size)) << name << " at " << plant.time() << " s";
      ASSERT_EQ(plant.step(tau, kStep), StepStatus::kOk);
    }
    RecordProperty(std::string("largest_") + name, text(largest));
    EXPECT_GT(compared, 1000) << name;
  }
}

TEST(Plant, KeepsTheEnergyOfAFrictionlessWrist) {
  const Model full = robot("psm-wrist");
  std::vector<EffectTerm> kept;
  for (const EffectTerm& term : full.effects()) {
    if (term.effect == "rotor_inertia" || term.effect == "joint_spring") kept.push_back(term);
  }
  // The insertion has no end in a free fall: a spring keeps it, and its energy counts.
  const double stiffness = 200.0;
  EffectTerm spring = effect(full, "joint_spring", 2, {{"stiffness", stiffness}});
  spring.axis.offset = -0.15;
  kept.push_back(spring);
  const Model arm = with_effects(full, kept);
  Plant plant(arm);
  Random random(5);
  VectorXd q = random.vector(7, -0.3, 0.3);
  q[2] = 0.15;
  plant.set_state(q, random.vector(7, -0.5, 0.5));
  const auto parts = [&] {
    const std::vector<double> at(plant.q().data(), plant.q().data() + 7);
    const std::vector<double> rate(plant.dq().data(), plant.dq().data() + 7);
    Energy<double> e = energy(arm, at, rate);
    for (const EffectTerm& term : arm.effects()) {
      const double s = term.axis.coefficients.dot(plant.q()) + term.axis.offset;
      const double ds = term.axis.coefficients.dot(plant.dq());
      if (term.effect == "joint_spring") e.potential += 0.5 * term.values.at("stiffness") * s * s;
      if (term.effect == "rotor_inertia") e.kinetic += 0.5 * term.values.at("inertia") * ds * ds;
    }
    return e;
  };
  const Energy<double> start = parts();
  double exchanged = 0.0;
  double drift = 0.0;
  const VectorXd none = VectorXd::Zero(7);
  for (int k = 0; k < 60000; ++k) {
    ASSERT_EQ(plant.step(none, kStep), StepStatus::kOk);
    const Energy<double> now = parts();
    exchanged = std::max(exchanged, std::abs(now.kinetic - start.kinetic));
    drift =
        std::max(drift, std::abs(now.kinetic + now.potential - start.kinetic - start.potential));
  }
  RecordProperty("drift_per_exchanged", text(drift / exchanged));
  EXPECT_GT(exchanged, 1.0);
  EXPECT_LT(drift, 1e-6 * exchanged) << drift / exchanged;
}

TEST(Plant, NothingIsAllocatedInAStep) {
  if (VERIDYN_COUNTS_MALLOC == 0) GTEST_SKIP() << "the sanitizer has a malloc of its own";
  Model arm = robot("psm-wrist");
  std::vector<EffectTerm> effects = arm.effects();
  effects.push_back(effect(arm, "presliding_hysteresis", 0, {{"level", 0.1}, {"distance", 5e-3}}));
  effects.push_back(effect(arm, "load_dependent_friction", 1, {{"coefficient", 0.06}}));
  arm = with_effects(arm, effects);
  Plant plant(arm);
  VectorXd tau = VectorXd::Zero(7);
  VectorXd ddq = tau;
  const long before = malloc_count();
  for (int k = 0; k < 2000; ++k) {
    for (int i = 0; i < 7; ++i) tau[i] = std::sin(0.01 * k + i);
    plant.accelerate(tau, ddq);
    plant.step(tau, kStep);
  }
  EXPECT_EQ(malloc_count(), before);
}

TEST(Plant, ANonFiniteTorqueStopsItAndNamesTheJoint) {
  const Model arm = robot("psm-3dof");
  Plant plant(arm);
  VectorXd tau = VectorXd::Zero(3);
  ASSERT_EQ(plant.step(tau, kStep), StepStatus::kOk);
  tau[1] = std::nan("");
  EXPECT_EQ(plant.step(tau, kStep), StepStatus::kNotFinite);
  EXPECT_EQ(plant.failed_joint(), JointIndex{1});
  EXPECT_TRUE(plant.q().allFinite());
  EXPECT_EQ(plant.time(), kStep);
  tau[1] = 1e308;  // overflows within the step
  EXPECT_NE(plant.step(tau, kStep), StepStatus::kOk);
  EXPECT_TRUE(plant.q().allFinite());
}

std::string refusal_of(const Model& arm) {
  return refusal([&] { Plant plant(arm); });
}

TEST(Plant, RefusesInfeasibleModelsAndNamesThePlace) {
  // Two links whose second has so large a first moment that M is indefinite where it is stretched.
  ModelDescription description = planar_2r().description();
  InertialParameters& phi = *description.frames[1].body->phi;
  phi.segment<3>(1) *= 6.0;
  const Model arm{ModelDescription(description)};
  const std::string message = refusal_of(arm);
  ASSERT_NE(message.find("mass matrix"), std::string::npos) << message;
  ASSERT_NE(message.find("q1 "), std::string::npos) << message;
  // At the configuration that it names M really has a negative eigenvalue.
  double q1 = 0.0, q2 = 0.0;
  ASSERT_EQ(std::sscanf(message.c_str() + message.find("q1 "), "q1 %lf rad, q2 %lf", &q1, &q2), 2);
  VectorXd q(2);
  q << q1, q2;
  const MatrixXd M = mass_matrix(arm, q);
  EXPECT_LE(M(0, 0) * M(1, 1) - M(0, 1) * M(1, 0), 0.0);
  EXPECT_EQ(refusal_of(planar_2r()), "");
}

TEST(Plant, RefusesAJointWithoutInertiaUnlessItsRotorIsFree) {
  const Model full = robot("psm-wrist");
  ModelDescription description = full.description();
  for (EffectTerm& term : description.effects) {
    if (term.effect != "rotor_inertia") continue;
    term.values["inertia"] = 1e-13;
    term.deviations["inertia"] = 2e-4;
  }
  const Model bound{ModelDescription(description)};
  EXPECT_NE(refusal_of(bound).find("of inertia at yaw "), std::string::npos) << refusal_of(bound);
  const MovableArm movable = with_movable_rotors(bound);
  EXPECT_EQ(movable.changed.size(), 4u);
  EXPECT_EQ(refusal_of(movable.arm), "");
  for (const EffectTerm& term : movable.arm.effects()) {
    if (term.effect != "rotor_inertia") continue;
    EXPECT_DOUBLE_EQ(term.values.at("inertia"), 2e-5);
  }
  // What was identified above its bound stays.
  EXPECT_TRUE(with_movable_rotors(full).changed.empty());
}

TEST(Plant, RefusesNegativeFriction) {
  const Model bare = planar_2r();
  const std::string message =
      refusal_of(with_effects(bare, {effect(bare, "viscous_friction", 1, {{"coefficient", -0.1}})}));
  EXPECT_NE(message.find("drives"), std::string::npos) << message;
  EXPECT_EQ(
      refusal_of(with_effects(bare, {effect(bare, "viscous_friction", 1, {{"coefficient", 0.1}})})),
      "");
}

}  // namespace
}  // namespace veridyn
