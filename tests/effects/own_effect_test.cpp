#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "support/simulated.hpp"
#include "cli/tool.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/excitation/excitation.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plant.hpp"
#include "veridyn/simulation/simulate_recording.hpp"

// An effect that is defined here and nowhere else: every room of the house must treat it like its
// own. docs/adding-an-effect.md prints the class.

namespace veridyn {
namespace {

/// Drag of an eddy-current brake: it rises with speed up to the peak and falls beyond it.
///
///   tau = 2 level x / (1 + x^2),   x = ds / peak_speed
///
/// The level is the largest drag. Source: Smythe, On eddy currents in a rotating disk, AIEE 61(9),
/// 1942.
class EddyCurrentBrake final : public AxisEffect {
 public:
  std::string name() const override { return "eddy_current_brake"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"level", "N m", "N", ParameterSign::kNonnegative}};
  }
  std::vector<EffectShape> shapes() const override {
    return {{"peak_speed", "rad/s", "m/s", 0.5, 0.01, 20.0}};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.role = EffectRole::kFriction;
    t.uses_velocity = true;
    return t;
  }
  void columns(const AxisSample& sample, const ShapeValues& shape, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    const double x = sample.ds / shape[0];
    row[0] = 2.0 * x / (1.0 + x * x);
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& shape,
                     JointType /*type*/) const override {
    return "an eddy-current brake of " + std::to_string(values[0]) + ", strongest at " +
           std::to_string(shape[0]);
  }
};

constexpr double kLevel = 3.0;  // [N m]
constexpr double kPeak = 0.35;  // [rad/s]
const char* const kHidden = "eddy_current_brake:shoulder:level=3,peak_speed=0.35";

// Three waves per joint at speeds on both sides of the peak; every seed is another motion.
MotionSamples motion(unsigned seed) {
  const Eigen::Index rows = 4001;
  MotionSamples m{VectorXd::LinSpaced(rows, 0.0, 20.0), MatrixXd::Zero(rows, 2),
                  MatrixXd::Zero(rows, 2), MatrixXd::Zero(rows, 2)};
  for (int i = 0; i < 2; ++i) {
    for (int k = 1; k <= 3; ++k) {
      const double w = 2.0 * M_PI * (0.05 * k + 0.35 * (k - 1)) * (i == 0 ? 1.0 : 1.2);
      const double size = 0.9 / (k * k);
      const Eigen::ArrayXd angle = w * m.time.array() + 1.7 * k * seed + 0.6 * i;
      m.q.col(i).array() += size * angle.sin();
      m.dq.col(i).array() += size * w * angle.cos();
      m.ddq.col(i).array() -= size * w * w * angle.sin();
    }
  }
  return m;
}

class OwnEffect : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!has_effect("eddy_current_brake")) register_effect(std::make_unique<EddyCurrentBrake>());
  }

  static Model plain() { return read_model("planar-2r"); }

  static Model with_brake(std::map<std::string, double> values) {
    ModelDescription d = plain().description();
    EffectTerm term;
    term.effect = "eddy_current_brake";
    term.axis.coefficients = VectorXd::Unit(2, 0);
    term.values = std::move(values);
    d.effects.push_back(std::move(term));
    return Model(std::move(d));
  }

  // Values of bodies and effects left out, so that they are identified.
  static Model unknown(const Model& arm) {
    ModelDescription d = arm.description();
    for (Frame& frame : d.frames) {
      if (frame.body) frame.body->phi.reset();
    }
    for (EffectTerm& term : d.effects) {
      for (const EffectParameter& p : find_effect(term.effect).parameters())
        term.values.erase(p.name);
    }
    return Model(std::move(d));
  }

  std::string recording(unsigned seed) const {
    SimulationOptions options;
    options.hidden.push_back(parse_hidden_effect(kHidden));
    options.noise = sensor_noise("dvrk");
    options.seed = seed;
    const SimulatedRecording s = simulate_recording(plain(), motion(seed), options);
    const std::string path = folder_.path("brake" + std::to_string(seed) + ".csv");
    write_recording(recording_of(s), path);
    return path;
  }

  TemporaryFolder folder_;
};

TEST_F(OwnEffect, IsKeptByARobotFileRoundTrip) {
  const std::string file = to_yaml(with_brake({{"level", kLevel}, {"peak_speed", kPeak}}));
  const Model again = read_yaml(file, "brake.yaml");
  EXPECT_EQ(again.effects().back().effect, "eddy_current_brake");
  EXPECT_EQ(again.effects().back().values.at("level"), kLevel);
  EXPECT_EQ(BoundEffect(again, again.effects().back()).parameter_name(0),
            "eddy_current_brake(shoulder).level");
}

TEST_F(OwnEffect, ItsLevelIsIdentifiedWithinFivePercent) {
  const Model arm = unknown(with_brake({{"peak_speed", kPeak}}));
  const Identification id = identify(arm, {recording(1), recording(2)}, {recording(3)});
  ASSERT_TRUE(id.model.has_value()) << id.reason;
  const EffectTerm& brake = id.model->effects().back();
  EXPECT_NEAR(brake.values.at("level"), kLevel, 0.05 * kLevel);
  EXPECT_LT(id.test_error.relative.maxCoeff(), 0.03);
}

TEST_F(OwnEffect, IsDiagnosedWithItsConstantRefined) {
  const Diagnosis d = diagnose(unknown(plain()), {recording(1), recording(2)}, {recording(3)});
  ASSERT_FALSE(d.findings.empty()) << d.report();
  const Finding& first = d.findings.front();
  EXPECT_EQ(effect_of(first.cause), "eddy_current_brake") << d.report();
  EXPECT_EQ(first.joint, JointIndex{0});
  ASSERT_EQ(first.parameters.size(), 2U);
  EXPECT_NEAR(first.parameters[0].value, kLevel, 0.1 * kLevel);
  const FoundParameter& peak = first.parameters[1];
  EXPECT_EQ(peak.name, "peak_speed");
  EXPECT_NEAR(peak.value, kPeak, 0.05 * kPeak);
  EXPECT_LT(peak.low, kPeak);
  EXPECT_GT(peak.high, kPeak);
  EXPECT_NE(first.phrase.find("an eddy-current brake of"), std::string::npos) << first.phrase;
}

// A request without numbers makes a tenth of the joint's effort, as for every other effect.
TEST_F(OwnEffect, IsInjectedWithAPositiveDefaultSize) {
  const PerturbedArm arm = inject_effects(plain(), {parse_hidden_effect("eddy_current_brake:1")});
  ASSERT_EQ(arm.effects.size(), 1U);
  EXPECT_GT(arm.effects[0].values.at("level"), 0.0);
  EXPECT_EQ(arm.effects[0].values.at("peak_speed"), 0.5);
}

// One joint with inertia J in free motion against the brake alone: J dv/dt = -2 level x/(1 + x^2)
// gives t = J p / (2 level) (ln(v0 / v) + (v0^2 - v^2) / (2 p^2)).
TEST_F(OwnEffect, ABrakedMotionFollowsItsClosedForm) {
  ModelDescription d = with_brake({{"level", kLevel}, {"peak_speed", kPeak}}).description();
  d.gravity.setZero();
  d.effects.erase(d.effects.begin(), d.effects.end() - 1);
  d.coordinates.resize(1);
  d.frames.resize(1);
  d.frames[0].variable.coefficients = VectorXd::Ones(1);
  d.effects[0].axis.coefficients = VectorXd::Ones(1);
  const Model arm(d);
  Plant plant(arm);
  const double v0 = 2.0;
  plant.set_state(VectorXd::Zero(1), VectorXd::Constant(1, v0));
  VectorXd ddq(1);
  ASSERT_EQ(plant.accelerate(VectorXd::Zero(1), ddq), StepStatus::kOk);
  const double x0 = v0 / kPeak;
  const double J = -2.0 * kLevel * x0 / (1.0 + x0 * x0) / ddq[0];
  ASSERT_GT(J, 0.0);
  while (plant.dq()[0] > 0.3) {
    ASSERT_EQ(plant.step(VectorXd::Zero(1), 1e-3), StepStatus::kOk);
    ASSERT_LT(plant.time(), 10.0);
  }
  const double v = plant.dq()[0];
  EXPECT_NEAR(
      plant.time(),
      J * kPeak / (2.0 * kLevel) * (std::log(v0 / v) + (v0 * v0 - v * v) / (2.0 * kPeak * kPeak)),
      1e-5);
}

TEST_F(OwnEffect, IsSeparatedByADesignedMotion) {
  ExcitationOptions options;
  options.criterion = ExcitationCriterion::kDiscriminate;
  options.between = {parse_cause(plain(), "eddy_current_brake:shoulder"), parse_cause(plain(), "stribeck_friction:1")};
  options.starts = 1;
  options.iterations = 5;
  const Excitation motion = optimise_excitation(plain(), options);
  ASSERT_TRUE(motion.discrimination.has_value());
  EXPECT_EQ(motion.discrimination->first, "eddy_current_brake:shoulder");
  EXPECT_GT(motion.discrimination->first_left, 0.0);
}

TEST_F(OwnEffect, FrictionCompensationHasItsForceAtEverySpeed) {
  const Model arm = with_brake({{"level", kLevel}, {"peak_speed", kPeak}});
  ModelDescription d = arm.description();
  d.effects.erase(d.effects.begin(), d.effects.end() - 1);
  const FrictionCompensation friction{Model(d)};
  ASSERT_EQ(friction.axes(), 1);
  for (const double speed : {0.2, kPeak, 3.0}) {
    const double x = speed / kPeak;
    EXPECT_NEAR(friction.sliding(0, 1.0, speed), kLevel * 2.0 * x / (1.0 + x * x), 1e-12);
    EXPECT_NEAR(friction.sliding(0, -1.0, speed), -kLevel * 2.0 * x / (1.0 + x * x), 1e-12);
  }
}

TEST_F(OwnEffect, ADuplicateNameIsRefused) {
  EXPECT_THROW(register_effect(std::make_unique<EddyCurrentBrake>()), InvalidInput);
}

}  // namespace
}  // namespace veridyn
