#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "veridyn/cooperation/scenario_run.hpp"

// Each feature of a scenario improves it: the same run with the feature off is worse. The guard,
// tracking with a damped force law and learned friction are in scenario_run_test.cpp.

namespace veridyn {
namespace {

Scenario shipped(const std::string& name) {
  return read_scenario(std::string(VERIDYN_SOURCE_DIR) + "/examples/cooperate/" + name + ".yaml");
}

// [m] of the leader's tip at the end of a phase, the largest.
double final_deflection(const Scenario& scenario) {
  const ScenarioRun run = run_scenario(scenario);
  EXPECT_TRUE(run.complete());
  double worst = 0.0;
  for (const PhaseFigures& p : run.phases) worst = std::max(worst, p.final_position_error);
  return worst;
}

// [N] of the first member or wall, mean over the last fifth of the first phase.
double force_at_rest(const Scenario& scenario) {
  const ScenarioRun run = run_scenario(scenario);
  EXPECT_TRUE(run.complete());
  const PhaseFigures& p = run.phases.front();
  double sum = 0.0;
  int count = 0;
  for (Eigen::Index k = 0; k < run.time.size(); ++k) {
    if (run.time[k] < p.to - 0.2 * (p.to - p.from) || run.time[k] > p.to) continue;
    sum += run.member[0].force[k];
    ++count;
  }
  return sum / count;
}

TEST(FeaturesOff, WithoutFrictionCompensationTheTipErrorIsLarger) {
  Scenario s = shipped("stick-slip");
  s.control.friction = 1.0;
  const double with = final_deflection(s);
  s.control.friction_rule = FrictionRule::kVelocity;
  EXPECT_GT(final_deflection(s), 4.0 * with);  // the thesis's rule without its part at rest
  s.control.friction = 0.0;
  EXPECT_GT(final_deflection(s), 4.0 * with);
}

TEST(FeaturesOff, WithoutTheModelErrorObserverTheDeflectionIsTenTimesLarger) {
  Scenario s = shipped("one-arm-moves");
  const double with = final_deflection(s);
  s.control.observer = 0.0;
  EXPECT_GT(final_deflection(s), 10.0 * with);
}

TEST(FeaturesOff, WithoutObjectImpedanceAHeldBodyDeviatesFiveTimesMore) {
  Scenario s = shipped("held-body");
  const ScenarioRun with = run_scenario(s);
  s.bodies[0].impedance_stiffness = 0.0;
  const ScenarioRun without = run_scenario(s);
  EXPECT_GT(without.phases[1].body_error, 5.0 * with.phases[1].body_error);
}

// Two hands that pull with the force F stretch their grasps, in opposite directions, by F over their stiffness.
TEST(FeaturesOff, AnInternalForceStretchesBothGraspsByForceOverStiffness) {
  const auto apart = [](double force) {
    Scenario s = shipped("held-body");
    s.model_error = 0.0;
    s.phases.resize(1);
    s.bodies[0].internal_force = force;
    s.bodies[0].grasps[1].stiffness = 2500.0;
    const ScenarioRun run = run_scenario(s);
    EXPECT_TRUE(run.complete());
    EXPECT_EQ(run.state, CooperativeState::kTracking);
    return (run.arm[1].tip.row(run.time.size() - 1) - run.arm[0].tip.row(run.time.size() - 1)).norm();
  };
  const double expected = 2.0 / 5000.0 + 2.0 / 2500.0;
  EXPECT_NEAR(apart(2.0) - apart(0.0), expected, 0.1 * expected);
}

// The impedance that is moved 15 mm into the tissue comes to rest where both forces are equal.
TEST(FeaturesOff, WithoutStiffeningTissueIsLinear) {
  Scenario s = shipped("tissue-stiffening");
  const double K = s.walls[0].stiffness, S = s.walls[0].stiffening, k = s.control.stiffness[2];
  ASSERT_GT(S, 0.0);
  const double into = 0.015;
  const double depth = (-(K + k) + std::sqrt((K + k) * (K + k) + 4.0 * S * k * into)) / (2.0 * S);
  EXPECT_NEAR(force_at_rest(s), (K + S * depth) * depth, 0.03);
  s.walls[0].stiffening = 0.0;
  EXPECT_NEAR(force_at_rest(s), K * k * into / (K + k), 0.03);
}

// [m] along the surface from the target to the tip, and [N s/m] the measured force over the tip's
// velocity, in the middle of the stroke.
struct Stroke {
  double lag = 0.0, felt = 0.0;
};
Stroke stroke_of(const Scenario& scenario) {
  const ScenarioRun run = run_scenario(scenario);
  EXPECT_TRUE(run.met()) << run.report();
  const PhaseFigures& p = run.phases[1];
  Stroke out;
  double rows = 0.0;
  for (Eigen::Index k = 1; k + 1 < run.time.size(); ++k) {
    if (std::abs(run.time[k] - 0.5 * (p.from + p.to)) > 0.1) continue;
    const Eigen::RowVector3d v =
        (run.arm[0].tip.row(k + 1) - run.arm[0].tip.row(k - 1)) / (run.time[k + 1] - run.time[k - 1]);
    const Eigen::Vector3d along(v[0], v[1], 0.0);
    const Eigen::Vector3d off = (run.arm[0].target.row(k) - run.arm[0].tip.row(k)).transpose();
    out.lag += off.dot(along) / along.squaredNorm();  // over the speed [s]
    if (run.member[0].axes.rows() > 0)
      out.felt -= run.member[0].axes.row(k).dot(along.transpose()) / along.squaredNorm();
    rows += 1.0;
  }
  return {out.lag / rows, out.felt / rows};
}

// The tissue drags the tip along its surface. The impedance yields to that by drag / stiffness times
// the speed where its sensor feels it, and not with a sensor of the normal alone.
TEST(FeaturesOff, OnlyAThreeAxisSensorMakesTheTipYieldToTissueDrag) {
  Scenario s = shipped("tissue-three-axes");
  const double drag = s.walls[0].drag;
  ASSERT_GT(drag, 0.0);
  const Stroke with = stroke_of(s);
  EXPECT_NEAR(with.felt, drag, 0.05 * drag);
  EXPECT_NEAR(with.lag, drag / s.control.stiffness[0], 0.15 * drag / s.control.stiffness[0]);
  s.walls[0].sensor_axes = 1;
  EXPECT_LT(std::abs(stroke_of(s).lag), 0.3 * with.lag);
  s.walls[0].sensor_axes = 3;
  s.walls[0].drag = 0.0;
  const Stroke smooth = stroke_of(s);
  EXPECT_LT(std::abs(smooth.felt), 0.05 * drag);
  EXPECT_LT(std::abs(smooth.lag), 0.3 * with.lag);
}

// A falling arm puts unplanned energy into the spring.
TEST(FeaturesOff, WithoutTheEnergyBoundAFallingArmIsDetectedLaterOrNever) {
  Scenario s = shipped("fault-limp");
  s.control.largest_force_error = 1000.0;
  s.control.largest_energy = 0.01;  // [J]
  const ScenarioRun with = run_scenario(s);
  s.control.largest_energy = 0.0;
  const ScenarioRun without = run_scenario(s);
  EXPECT_NE(with.state, CooperativeState::kTracking);
  EXPECT_NE(with.state, without.state) << describe(with.state);
  EXPECT_TRUE(without.state == CooperativeState::kTracking || with.held_at < without.held_at);
}

// While targets are held an arm yields to more than relief_force; without that the falling arm pulls
// harder.
TEST(FeaturesOff, WithoutYieldingAFallingArmPullsHarder) {
  Scenario s = shipped("fault-limp");
  const double with = run_scenario(s).largest_force;
  s.control.relief_force = 1000.0;
  EXPECT_GT(run_scenario(s).largest_force, 1.3 * with);
}

}  // namespace
}  // namespace veridyn
