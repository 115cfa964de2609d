#include "veridyn/cooperation/stability.hpp"

#include <gtest/gtest.h>

#include <unistd.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <string>
#include <vector>

#include "cooperation/experiment.hpp"
#include "cooperation/stability/loop_search.hpp"
#include "cooperation/stability/sample_pattern.hpp"
#include "math/singular_values.hpp"
#include "support/near.hpp"
#include "support/refusal.hpp"
#include "veridyn/cooperation/scenario_run.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"

// The linear closed loop against the nonlinear simulation of the same scenario.

namespace veridyn {
namespace {

Scenario example(const std::string& name) {
  return read_scenario(std::string(VERIDYN_SOURCE_DIR) + "/examples/cooperate/" + name + ".yaml");
}

// The example without dry friction, encoder steps and noise, which a linear loop can match.
class WithoutFriction : public testing::Test {
 protected:
  Scenario smooth(const std::string& name) {
    ModelDescription arm = plausible_model(read_model("psm-3dof"), 1).arm.description();
    for (EffectTerm& effect : arm.effects) {
      if (effect.effect == "coulomb_friction") effect.values["level"] = 0.0;
    }
    save_yaml(Model(std::move(arm)));
    Scenario s = example(name);
    for (ScenarioArm& a : s.arms) a.model = path_;
    s.encoder = "none";
    s.control.friction = 0.0;
    for (ScenarioMember& m : s.members) m.sensor.noise = 0.0;
    s.phases.resize(1);
    return s;
  }
  void save_yaml(const Model& arm) const {
    std::FILE* file = std::fopen(path_.c_str(), "w");
    ASSERT_NE(file, nullptr);
    std::fputs(to_yaml(arm).c_str(), file);
    std::fclose(file);
  }
  ~WithoutFriction() override { std::remove(path_.c_str()); }

  std::string path_ = testing::TempDir() + "smooth-" + std::to_string(::getpid()) + ".yaml";
};

// How the true force answers a small step of the wanted one, cycle by cycle: from the difference of
// two simulations, and from the linear loop. Sensors of the loop's own rate, of half of it and of
// two fifths and of a fortieth, delays that are no whole cycles, a lag of the motors and a filter of the force.
TEST_F(WithoutFriction, TheLinearCycleMatchesTheSimulatedOne) {
  struct Case {
    const char* name;
    double stiffness, delay, sensor_rate, motor_lag, force_cutoff;
    int torque_delay;
  };
  const Case cases[] = {{"two-arms-spring", 2450.0, 0.002, 500.0, 0.0, 0.0, 0},
                        {"two-arms-string", 20000.0, 0.0025, 400.0, 0.002, 100.0, 0},
                        {"gazebo-y", 1000.0, 0.0, 1000.0, 0.0, 0.0, 1},
                        {"gazebo-y", 500.0, 0.004, 10.0, 0.0, 0.0, 0}};
  constexpr int kSettled = 2500;
  constexpr int kCompared = 300;
  constexpr double kStep = 1e-4;  // [N]
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    Scenario s = smooth(c.name);
    s = with_parameter(s, "stiffness", c.stiffness);
    s = with_parameter(s, "delay", c.delay);
    s = with_parameter(s, "sensor_rate", c.sensor_rate);
    s.control.motor_lag = c.motor_lag;
    s.control.force_cutoff = c.force_cutoff;
    s.control.torque_delay = c.torque_delay;
    s.control.largest_age = std::max(s.control.largest_age, 4.0 / c.sensor_rate);
    Experiment still(s, "veridyn"), stepped(s, "veridyn");
    still.begin_phase(s.phases[0]);
    stepped.begin_phase(s.phases[0]);
    for (int k = 0; k < kSettled; ++k) {
      ASSERT_TRUE(still.step());
      ASSERT_TRUE(stepped.step());
    }
    ScenarioCommand rise;
    rise.kind = ScenarioCommand::Kind::kForce;
    rise.member = 0;
    rise.amount = 5.0 + kStep;
    rise.over = 1e-6;
    ASSERT_TRUE(stepped.execute(rise));
    LoopSettings settings;
    settings.wanted = kStep;
    const std::vector<RestPoint> points = rest_points(s);
    const ClosedLoop loop(points.back().loop, s, settings);
    MatrixXd x = MatrixXd::Zero(loop.states(), 1);
    double largest = 0.0, off = 0.0;
    for (int k = kSettled; k < kSettled + kCompared; ++k) {
      still.step();
      stepped.step();
      loop.advance(k, x);
      const double simulated = stepped.world().member(0).tension - still.world().member(0).tension;
      const double linear = loop.tension_row(0).dot(x.col(0));
      largest = std::max(largest, std::abs(simulated));
      off = std::max(off, std::abs(simulated - linear));
    }
    EXPECT_GT(largest, 0.2 * kStep);
    // The planned pose of rest differs from the true one by the deflection of arms and object.
    EXPECT_LT(off, 0.03 * largest) << off / largest;
  }
}

// The simulated force swings as often, in its last second, and as far but for what one increment stretches the spring by.
TEST_F(WithoutFriction, ALoopWithANarrowDeadbandOscillatesLikeItsLinearModel) {
  const Scenario s = smooth("position-limit-cycle");
  const DeadbandSwing linear = deadband_swing(rest_points(s).back().loop, s, 0);
  ASSERT_TRUE(linear.swings);
  const auto second = static_cast<Eigen::Index>(s.control.rate);
  const VectorXd force = run_scenario(s).member[0].force.tail(second);
  const double middle = 0.5 * (force.maxCoeff() + force.minCoeff()), half = force.maxCoeff() - middle;
  EXPECT_NEAR(linear.amplitude, half, s.members[0].law.increment * s.members[0].stiffness);
  int turns = 0;
  for (Eigen::Index k = 1; k < second; ++k) turns += (force[k] > middle) != (force[k - 1] > middle) ? 1 : 0;
  EXPECT_NEAR(linear.frequency, 0.5 * turns, 0.1 * turns);
}

// At its margins the loop is on the unit circle, by another computation of the same eigenvalues.
TEST(Stability, TheSpectralRadiusCrossesOneAtTheStatedMargins) {
  const Scenario s = example("two-arms-spring");
  const StabilityAnalysis a = analyse_stability(s);
  EXPECT_TRUE(a.stable);
  EXPECT_GT(a.margins.gain, 1.0);
  EXPECT_GT(a.margins.phase_deg, 10.0);
  EXPECT_GT(a.margins.delay, 0.001);
  const std::vector<RestPoint> points = rest_points(s);
  for (const RestPoint& p : points) {
    if (p.time != a.worst.time) continue;
    LoopSettings gain;
    gain.reading_gain = 1.001 * a.margins.gain;
    EXPECT_GT(loop_radius(p.loop, s, gain), 1.0);
    gain.reading_gain = 0.999 * a.margins.gain;
    EXPECT_LT(loop_radius(p.loop, s, gain), 1.0);
    // Whole cycles of delay, through the scenario itself.
    const double period = 1.0 / s.control.rate;
    const double whole = period * std::floor(a.margins.delay / period);
    EXPECT_LT(loop_radius(p.loop, with_parameter(s, "delay", 0.002 + whole)), 1.0 + 1e-9);
    EXPECT_GT(loop_radius(p.loop, with_parameter(s, "delay", 0.002 + whole + period)), 1.0);
  }
  // All eigenvalues of the report lie within the circle, and the largest is its radius.
  double largest = 0.0;
  for (const auto& [re, im] : a.eigenvalues) largest = std::max(largest, std::hypot(re, im));
  EXPECT_NEAR(std::pow(largest, 1.0 / a.cycles), a.radius, 1e-12);
}

// Thesis 7.7.3, figure 7.10: a deadband of 0.2 N swings, 0.4 N does not.
TEST(Stability, ADeadbandOfOneFifthNewtonOscillatesAndOfTwoFifthsDoesNot) {
  const StabilityAnalysis narrow = analyse_stability(example("position-limit-cycle"));
  const StabilityAnalysis wide = analyse_stability(example("position-stable"));
  ASSERT_EQ(narrow.deadbands.size(), 1U);
  EXPECT_TRUE(narrow.deadbands[0].swings);
  EXPECT_FALSE(narrow.stable);
  EXPECT_FALSE(wide.deadbands[0].swings);
  EXPECT_TRUE(wide.stable);
}

// The gain from a missing torque to accelerations, by another computation: responses to a pulse on each joint in each cycle of a
// hyperperiod, transformed. No frequency exceeds the gain; the gain exceeds the largest singular value by less than the
// Frobenius norm does.
TEST(Stability, TheGainFromTorqueErrorsBoundsThePulseResponsesAtEveryFrequency) {
  struct Case {
    const char* name;
    double sensor_rate;
    int hyperperiod;
  };
  constexpr int kFrequencies = 30, kPeriods = 4000;
  for (const Case& c : {Case{"gazebo-y", 1000.0, 1}, Case{"two-arms-string", 400.0, 5}}) {
    SCOPED_TRACE(c.name);
    Scenario s = with_parameter(example(c.name), "sensor_rate", c.sensor_rate);
    s.model_error = 0.0;
    const LinearPoint point = rest_points(s).back().loop;
    const ClosedLoop loop(point, s, {});
    const Eigen::Index h = loop.hyperperiod(), n = loop.joints();
    ASSERT_EQ(h, c.hyperperiod);
    MatrixXd root = MatrixXd::Zero(n, n);
    Eigen::Index first = 0;
    for (const LinearArm& arm : point.arms) {
      root.block(first, first, arm.joints(), arm.joints()) = arm.M.llt().matrixL();
      first += arm.joints();
    }
    MatrixXd X = MatrixXd::Zero(loop.states(), h * n);  // a column for every pulse
    std::vector<Eigen::MatrixXcd> T(kFrequencies + 1, Eigen::MatrixXcd::Zero(h * n, h * n));
    std::vector<double> angles;
    for (int k = 0; k <= kFrequencies; ++k) angles.push_back(M_PI * std::pow(10.0, 3.0 * k / kFrequencies - 3.0));
    for (long cycle = 0; cycle < kPeriods * h; ++cycle) {
      const MatrixXd before = X.middleRows(n, n);
      loop.advance(cycle, X);
      if (cycle < h) X.block(0, cycle * n, 2 * n, n) += loop.torque_input() * root;
      const MatrixXd z = root.transpose() * (X.middleRows(n, n) - before) / loop.period();
      for (size_t k = 0; k < T.size(); ++k)
        T[k].middleRows(cycle % h * n, n) += std::polar(1.0, -angles[k] * static_cast<double>(cycle / h)) * z;
    }
    double largest = 0.0;
    for (const Eigen::MatrixXcd& one : T) {
      MatrixXd real(2 * h * n, 2 * h * n);  // the same singular values, twice each
      real << one.real(), -one.imag(), one.imag(), one.real();
      largest = std::max(largest, singular_values(real)[0]);
    }
    const double gain = torque_error_gain(point, s, kFrequencies);
    EXPECT_GT(gain, (1.0 - 1e-6) * largest);
    EXPECT_LT(gain, std::pow(static_cast<double>(h * n), 0.25) * largest);
  }
}

// The stiffness that a force on the tip adds is the slope of -J' f, with f on the true arm and -f, exerted, on the known one;
// sliding slowly, only viscous friction grows with speed.
TEST(LinearArm, ATipForceAddsTheStiffnessOfTheJacobiansSlope) {
  const Scenario s = example("two-arms-spring");
  const ScenarioModels models = scenario_models(s, 1);
  const Eigen::Vector3d q(0.2, -0.4, 0.14), force(30.0, -20.0, 50.0), none = Eigen::Vector3d::Zero();
  const LinearArm arm = linear_arm(models, s.arms[1], q, force, force), free = linear_arm(models, s.arms[1], q, none, none);
  constexpr double kStep = 1e-5;
  MatrixXd slope(3, 3), known(3, 3);
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
    const LinearArm up = linear_arm(models, s.arms[1], q + step, none, none), down = linear_arm(models, s.arms[1], q - step, none, none);
    slope.col(i) = -(up.J - down.J).transpose() * force / (2.0 * kStep);
    known.col(i) = (up.J_known - down.J_known).transpose() * force / (2.0 * kStep);
  }
  EXPECT_GT(slope.norm(), 1.0);
  EXPECT_TRUE(near(arm.G - free.G, slope, 1e-4));
  EXPECT_TRUE(near(arm.G_known - free.G_known, known, 1e-4));
  MatrixXd drag = MatrixXd::Zero(3, 3);
  for (const EffectTerm& term : models.real.effects()) {
    const VectorXd& c = term.axis.coefficients;
    if (term.effect == "viscous_friction") drag += term.values.at("coefficient") * c * c.transpose();
  }
  EXPECT_GT(drag.norm(), 0.01);
  EXPECT_TRUE(near(arm.D, drag, 1e-9));
}

TEST(Stability, InvalidParametersAndRangesAreRefused) {
  const Scenario s = example("two-arms-spring");
  EXPECT_EQ(parameter(with_parameter(s, "stiffness", 123.0), "stiffness"), 123.0);
  EXPECT_THROW(with_parameter(s, "stifness", 1.0), InvalidInput);
  EXPECT_THROW(with_parameter(s, "stiffness", 0.0), InvalidInput);
  EXPECT_EQ(with_parameter(s, "torque_delay", 1000.0).control.torque_delay, 1000);
  EXPECT_THROW(with_parameter(s, "torque_delay", 1e300), InvalidInput);
  EXPECT_THROW(parse_range("stiffness=5:1:3"), InvalidInput);
  EXPECT_THROW(parse_range("stiffness=1:5"), InvalidInput);
  const ParameterRange range = parse_range("stiffness=100:10000:3");
  EXPECT_NEAR(range.values()[1], 1000.0, 1e-9);
}

// Below half of the intervals a corner may be unstable already, or with exact parameters.
TEST(Stability, TheIntervalFactorIsTheLargestWithoutAnUnstableSample) {
  constexpr int kSamples = 2;
  constexpr double kResolution = 0.5 / 4096.0;  // twelve halvings
  const Scenario unstable = with_parameter(example("gazebo-y"), "stiffness", 1e6);
  const StabilityBounds none = bound_stability(unstable, kSamples, 1);
  EXPECT_EQ(none.unstable, kSamples);
  EXPECT_EQ(none.factor, 0.0);
  EXPECT_TRUE(none.factor_bounded);
  EXPECT_EQ(none.guaranteed_mass_error, 0.0);  // of an unstable loop nothing is guaranteed
  Scenario exact = example("gazebo-y");
  exact.model_error = 0.0;
  const double limit = [&] {
    const std::vector<RestPoint> points = rest_points(exact);
    return first_crossing(
        [&](double stiffness) {
          double worst = 0.0;
          for (const RestPoint& p : points)
            worst = std::max(worst, loop_radius(p.loop, with_parameter(exact, "stiffness", stiffness)));
          return worst;
        },
        1000.0, 1e6, 10);
  }();
  Scenario near_it = with_parameter(example("gazebo-y"), "stiffness", 0.98 * limit);
  near_it.model_error = 0.4;
  const StabilityBounds some = bound_stability(near_it, kSamples, 1);
  EXPECT_GT(some.factor, 10.0 * kResolution);
  EXPECT_LT(some.factor, 0.5);
  Scenario within = near_it, beyond = near_it;
  within.model_error *= some.factor;
  beyond.model_error *= some.factor + 2.0 * kResolution;
  EXPECT_EQ(bound_stability(within, kSamples, 1).unstable, 0);
  EXPECT_GT(bound_stability(within, kSamples, 1).guaranteed_mass_error, 0.0);
  EXPECT_GT(bound_stability(beyond, kSamples, 1).unstable, 0);
  EXPECT_THROW(bound_stability(near_it, 0, 1), InvalidInput);
}

// If numbers overflow before the last second, the amplitude is infinite.
TEST(Stability, ALoopThatIsUnstableWithoutEncoderStepsOscillatesWithThem) {
  const Scenario s = with_parameter(example("position-stable"), "law_damping", 50.0);
  const LinearPoint point = rest_points(s).back().loop;
  ASSERT_GT(loop_radius(point, s), 1.1);
  const DeadbandSwing swing = deadband_swing(point, s, 0);
  EXPECT_TRUE(swing.swings);
  EXPECT_TRUE(std::isinf(swing.amplitude));
}

TEST(SamplePattern, IsExactForShortPeriodsAndApproximateForLongOnes) {
  struct Case {
    std::vector<double> given;
    int cycles;
    std::vector<double> ratios;
  };
  const Case cases[] = {{{}, 1, {}},
                        {{1.5, 1.0}, 1, {1.0, 1.0}},
                        {{0.4}, 5, {0.4}},
                        {{1.0 / 24.0}, 24, {1.0 / 24.0}},
                        {{0.02}, 50, {0.02}},
                        {{1.0 / 49.6}, 50, {0.02}},
                        {{0.001}, 1000, {0.001}},
                        {{0.2, 1.0 / 7.0}, 35, {0.2, 1.0 / 7.0}},
                        {{0.97}, 24, {23.0 / 24.0}},
                        {{1.0 / 23.0, 1.0 / 19.0, 1.0 / 17.0}, 989, {43.0 / 989.0, 52.0 / 989.0, 58.0 / 989.0}}};
  for (const Case& c : cases) {
    const SamplePattern p = sample_pattern(c.given);
    EXPECT_EQ(p.cycles, c.cycles);
    ASSERT_EQ(p.ratios.size(), c.ratios.size());
    for (size_t k = 0; k < c.ratios.size(); ++k) EXPECT_NEAR(p.ratios[k], c.ratios[k], 1e-12) << c.cycles;
  }
  for (double ratio = 0.001; ratio < 1.0; ratio *= 1.003)  // within 4 %
    EXPECT_NEAR(sample_pattern({ratio}).ratios[0] / ratio, 1.0, 0.041) << ratio;
  EXPECT_THROW(sample_pattern({1e-3, 0.9e-3}), InvalidInput);
}

// A sensor of a 40th of the loop's rate is analysed as it is, and the map of its pattern, of which powers are taken, is
// the product of its cycles. It bears less than the same sensor of a 24th.
TEST(Stability, ASlowSensorIsAnalysedAtItsOwnRate) {
  const Scenario s = with_parameter(example("gazebo-y"), "sensor_rate", 10.0);
  const LinearPoint point = rest_points(s).back().loop;
  const ClosedLoop loop(point, s, {});
  ASSERT_EQ(loop.hyperperiod(), 40);
  MatrixXd one_by_one = MatrixXd::Identity(loop.states(), loop.states());
  for (int k = 0; k < 40; ++k) loop.advance(loop.first_cycle() + k, one_by_one);
  const MatrixXd map = loop.map();
  EXPECT_LT((map - one_by_one).norm(), 1e-10 * one_by_one.norm());
  const auto radius = [&](double rate, double stiffness) {
    return loop_radius(point, with_parameter(with_parameter(s, "sensor_rate", rate), "stiffness", stiffness));
  };
  const auto limit = [&](double rate) {
    return first_crossing([&](double stiffness) { return radius(rate, stiffness); }, 100.0, 1e6, 40);
  };
  EXPECT_LT(limit(10.0), 0.9 * limit(400.0 / 24.0));
  EXPECT_LT(limit(5.0), 0.9 * limit(10.0));
}

// Replaced rates are reported; a sensor of a very low rate is refused.
TEST(Stability, ReplacedSensorRatesAreReported) {
  Scenario s = with_parameter(example("two-arms-spring"), "sensor_rate", 970.0);
  s.phases.resize(1);
  const StabilityAnalysis a = analyse_stability(s);
  ASSERT_EQ(a.replaced_rates.size(), 1U);
  EXPECT_EQ(a.replaced_rates[0].sensor, "spring");
  EXPECT_EQ(a.replaced_rates[0].rate, 970.0);
  EXPECT_NEAR(a.replaced_rates[0].analysed, 1000.0 * 23.0 / 24.0, 1e-9);
  EXPECT_NE(a.report().find("The sensor of spring is analysed with 958.333 Hz in place of its 970 Hz"), std::string::npos) << a.report();
  EXPECT_TRUE(analyse_stability(with_parameter(s, "sensor_rate", 2000.0)).replaced_rates.empty());
  EXPECT_TRUE(refuses_with("one sample in 2000 cycles", [&] { analyse_stability(with_parameter(s, "sensor_rate", 0.5)); }));
}

// Where no stiffness below the scenario's own is stable the ones above are searched; if there is none at all, this is reported.
TEST(Stability, TheSearchFindsStableStiffnessesAboveTheScenarios) {
  Scenario s = example("gazebo-y");
  s.control.force_cutoff = 106.0;
  s = with_parameter(with_parameter(s, "delay", 0.00716), "stiffness", 3.0);
  const StabilityAnalysis soft = analyse_stability(s);
  EXPECT_FALSE(soft.stable);
  EXPECT_GT(soft.smallest_stable_stiffness, 3.0);
  EXPECT_GT(soft.linear_stable_stiffness, 2.0 * soft.smallest_stable_stiffness);
  EXPECT_NE(soft.report().find("as given, the scenario is not stable"), std::string::npos) << soft.report();
  const std::vector<RestPoint> points = rest_points(s);
  for (const RestPoint& p : points) {
    if (p.time != soft.worst.time) continue;
    const auto radius = [&](double stiffness) { return loop_radius(p.loop, with_parameter(s, "stiffness", stiffness)); };
    EXPECT_GT(radius(0.99 * soft.smallest_stable_stiffness), 1.0);
    EXPECT_LT(radius(1.01 * soft.smallest_stable_stiffness), 1.0);
    EXPECT_LT(radius(0.99 * soft.linear_stable_stiffness), 1.0);
    EXPECT_GT(radius(1.01 * soft.linear_stable_stiffness), 1.0);
  }
  const StabilityAnalysis none = analyse_stability(with_parameter(example("position-stable"), "law_damping", 50.0));
  EXPECT_EQ(none.linear_stable_stiffness, 0.0);
  EXPECT_NE(none.report().find("none from 1 to 1e+07 N/m is stable"), std::string::npos) << none.report();
}

// Where nothing ever moves no simulation swings, however stiff the object: dry friction holds up to the end of the search.
TEST(Stability, ALoopAtRestWithDryFrictionIsStableAtEverySearchedStiffness) {
  Scenario s = example("gazebo-y");
  s.encoder = "none";
  s.model_error = 0.0;
  s.phases.resize(1);
  s.phases[0].commands.clear();
  s.phases[0].duration = 0.05;
  for (ScenarioMember& m : s.members) m.sensor.noise = 0.0;
  const StabilityAnalysis a = analyse_stability(s);
  EXPECT_LT(a.linear_stable_stiffness, 1e6);
  EXPECT_GT(a.simulated_runs, 5);
  EXPECT_EQ(a.largest_stable_stiffness, 1e7);
  EXPECT_NE(a.report().find("with the arms' dry friction up to 1e+07 N/m, the end of the search"), std::string::npos) << a.report();
}

}  // namespace
}  // namespace veridyn
