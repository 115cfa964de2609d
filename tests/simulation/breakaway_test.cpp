#include "veridyn/simulation/breakaway.hpp"

#include <gtest/gtest.h>

#include "simulation/plant_support.hpp"

namespace veridyn {
namespace {

constexpr double kStep = 0.01;
constexpr double kRate = 0.2;             // [N/s] of the ramps
constexpr Eigen::Index kRampRows = 1200;  // 12 s
const double kTooFar = 0.08;              // [m] from home: the recorded one is stopped there

// What a machine of this arm records in ramps of force, up and down in turn, each from a new place
// at which it was pressed with `preload` before.
ReplayInput recorded_ramps(const Model& arm, int ramps, double preload) {
  const Eigen::Index rows = ramps * kRampRows;
  ReplayInput in;
  in.motion.time = VectorXd::LinSpaced(rows, 0.0, kStep * static_cast<double>(rows - 1));
  in.motion.q = in.motion.dq = in.motion.ddq = in.tau = MatrixXd::Zero(rows, 1);
  in.use.assign(static_cast<size_t>(rows), 1);
  Plant plant(arm);
  for (Eigen::Index k = 0; k < rows; ++k) {
    const Eigen::Index ramp = k / kRampRows;
    const double home = 0.1 + 0.15 * static_cast<double>(ramp % 2);
    if (k % kRampRows == 0) {
      plant.set_state(one(home), one(0.0));
      for (int p = 0; p < 300; ++p) plant.step(one(preload - 20.0 * plant.dq()[0]), kStep);
    }
    const double t = kStep * static_cast<double>(k % kRampRows);
    // A second at rest first.
    const double tau = preload + (ramp % 2 == 0 ? kRate : -kRate) * std::max(0.0, t - 1.0);
    in.motion.q(k, 0) = plant.q()[0];
    in.tau(k, 0) = tau;
    if (std::abs(plant.q()[0] - home) > kTooFar) continue;
    EXPECT_EQ(plant.step(one(tau), kStep), StepStatus::kOk);
  }
  return in;
}

Model with_coulomb(double level) {
  return with_effects(slide(), {effect(slide(), "coulomb_friction", 0, {{"level", level}})});
}

// A block gives way at its level, and a model with half the level at half.
TEST(Breakaway, EqualsTheLevelOfCoulombFriction) {
  const double level = 1.2;
  const Model arm = with_coulomb(level);
  const ReplayInput input = recorded_ramps(arm, 4, 0.0);
  Plant plant(arm);
  const Breakaway same = breakaway(plant, arm, input, {});
  ASSERT_EQ(same.events.size(), 4u);
  // Once it slides it gains speed by the ramp's own rate: 5 mm/s after some tenths of a second.
  EXPECT_NEAR(same.recorded_forward, level, 0.06);
  EXPECT_NEAR(same.simulated_forward, same.recorded_forward, 0.01);
  EXPECT_NEAR(same.simulated_backward, same.recorded_backward, 0.01);
  Plant smoother(with_coulomb(0.5 * level));
  const Breakaway half = breakaway(smoother, with_coulomb(0.5 * level), input, {});
  EXPECT_NEAR(half.simulated_forward, 0.5 * level, 0.06);
  EXPECT_NEAR(half.simulated_backward, -0.5 * level, 0.06);
  Plant rougher(with_coulomb(1.5 * level));  // gives way after the recorded one did
  EXPECT_NEAR(breakaway(rougher, with_coulomb(1.5 * level), input, {}).simulated_forward,
              1.5 * level, 0.06);
}

// Friction with a memory of 2 mm creeps by millimetres before it slides: that is no breakaway yet,
// and a rest under a preload that Coulomb friction alone could not hold is a rest of the model too.
TEST(Breakaway, CreepIsNotCountedAsBreakaway) {
  const Model arm = with_effects(
      slide(), {effect(slide(), "coulomb_friction", 0, {{"level", 0.4}}),
                effect(slide(), "presliding_hysteresis", 0, {{"level", 0.8}, {"distance", 2e-3}})});
  const double preload = 0.6;
  const ReplayInput input = recorded_ramps(arm, 4, preload);
  Plant plant(arm);
  const Breakaway same = breakaway(plant, arm, input, {});
  ASSERT_EQ(same.events.size(), 4u);
  EXPECT_NEAR(same.recorded_forward, 1.2, 0.15);
  EXPECT_NEAR(same.recorded_backward, -1.2, 0.15);
  EXPECT_NEAR(same.simulated_forward, same.recorded_forward, 0.03);
  EXPECT_NEAR(same.simulated_backward, same.recorded_backward, 0.03);
  // The simulated curve is the recorded one, the creep before the ramp taken off.
  for (const BreakawayEvent& e : same.events) {
    const auto row = static_cast<Eigen::Index>(std::lround(e.rest_from / kStep)) + 200;
    EXPECT_NEAR(same.simulated_q[row], input.motion.q(row, 0), 1e-4) << e.rest_from;
  }
}

}  // namespace
}  // namespace veridyn
