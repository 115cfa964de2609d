#include <gtest/gtest.h>

#include <cmath>

#include "simulation/plant_support.hpp"
#include "support/near.hpp"

// How exact the motion of a Plant is.

namespace veridyn {
namespace {

// Between samples the memory runs along the path that the plant really went: the inverse dynamics
// above see every millisecond only, and still agree. Where the path turns round within a
// millisecond the plant must be the better one: halving its steps changes nothing.
TEST(Plant, MotionDoesNotDependOnTheStep) {
  Model arm = robot("psm-3dof");
  std::vector<EffectTerm> effects = arm.effects();
  effects.push_back(effect(arm, "presliding_hysteresis", 2, {{"level", 0.4}, {"distance", 2e-4}}));
  arm = with_effects(arm, effects);
  const auto end_of = [&](double step, double tolerance) {
    PlantOptions options;
    options.tolerance = tolerance;
    Plant plant(arm, options);
    const VectorXd zero = VectorXd::Zero(3);
    plant.set_state(zero, zero);
    const auto steps = static_cast<int>(std::lround(2.0 / step));
    for (int k = 0; k < steps; ++k) {
      // Constant over 10 ms whatever the step, so that all plants see the same torques.
      const double t = 0.01 * std::floor((k + 0.5) * step / 0.01);
      EXPECT_EQ(plant.step(swinging_torque(3, t), step), StepStatus::kOk);
    }
    VectorXd state(6);
    state << plant.q(), plant.dq();
    return state;
  };
  const VectorXd exact = end_of(1e-4, 1e-10);
  EXPECT_TRUE(near(end_of(1e-3, 1e-6), exact, 1e-6));
  EXPECT_TRUE(near(end_of(1e-2, 1e-6), exact, 1e-5));
}

// The error falls with the tolerance, and is of its size.
TEST(Plant, TheErrorFallsWithTheTolerance) {
  const Model arm =
      with_effects(planar_2r(), {effect(planar_2r(), "joint_spring", 0, {{"stiffness", 4000.0}}),
                                 effect(planar_2r(), "joint_spring", 1, {{"stiffness", 900.0}})});
  const auto end_of = [&](double tolerance) {
    PlantOptions options;
    options.tolerance = tolerance;
    options.most_substeps = 1000000;
    Plant plant(arm, options);
    plant.set_state(VectorXd::Constant(2, 0.1), VectorXd::Zero(2));
    for (int k = 0; k < 10; ++k) EXPECT_EQ(plant.step(VectorXd::Zero(2), 0.1), StepStatus::kOk);
    return std::make_pair(VectorXd(plant.q()), plant.work().taken);
  };
  const VectorXd exact = end_of(1e-13).first;
  double last = 1.0;
  long work = 0;
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
    const auto [q, taken] = end_of(tolerance);
    const double error = (q - exact).cwiseAbs().maxCoeff() / 0.1;
    EXPECT_LT(error, 300.0 * tolerance) << tolerance;  // some hundred substeps add up
    EXPECT_LT(error, 0.2 * last) << tolerance;
    EXPECT_GT(taken, work);
    last = error;
    work = taken;
  }
}

// One substep a step: halving it divides the error by 2^4, whichever way the stages are evaluated.
TEST(Plant, TheIntegrationErrorIsOfFourthOrder) {
  for (const char* name : {"psm-3dof", "psm-wrist", "ur10e"}) {
    const Model full = robot(name);
    const int n = full.joints();
    std::vector<EffectTerm> smooth;
    for (const EffectTerm& term : full.effects()) {
      if (term.effect == "rotor_inertia" || term.effect == "viscous_friction")
        smooth.push_back(term);
    }
    const Model arm = with_effects(full, smooth);
    PlantOptions options;
    options.tolerance = 1e9;
    const auto end_of = [&](int steps) {
      Plant plant(arm, options);
      plant.set_state(VectorXd::Constant(n, 0.2), VectorXd::LinSpaced(n, 1.0, -0.5));
      VectorXd tau = VectorXd::LinSpaced(n, 2.0, 0.01);
      for (int k = 0; k < steps; ++k) EXPECT_EQ(plant.step(tau, 0.4 / steps), StepStatus::kOk);
      EXPECT_EQ(plant.work().taken, steps);
      VectorXd state(2 * n);
      state << plant.q(), plant.dq();
      return state;
    };
    const VectorXd exact = end_of(3200);
    const double coarse = (end_of(100) - exact).norm();
    const double fine = (end_of(200) - exact).norm();
    EXPECT_GT(fine, 1e-13) << name;  // above rounding
    EXPECT_NEAR(std::log2(coarse / fine), 4.0, 0.4) << name << ": " << coarse << ", " << fine;
  }
}

}  // namespace
}  // namespace veridyn
