#include "veridyn/identification/friction_curve.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "veridyn/files/model_file.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn {
namespace {

// planar-2r as if identified from one recording: the shoulder at 0.7 rad, up to 2 rad/s; the elbow at rest.
Identification identified(ModelDescription description) {
  Identification id;
  id.model = Model(std::move(description));
  const std::vector<StandardParameter> parameters = standard_parameters(*id.model);
  id.parameter_deviations = VectorXd::Zero(static_cast<Eigen::Index>(parameters.size()));
  for (size_t p = 0; p < parameters.size(); ++p) {
    if (parameters[p].name == "viscous_friction(shoulder).coefficient") id.parameter_deviations[static_cast<Eigen::Index>(p)] = 0.1;
  }
  RecordingError recording;
  recording.series.time = {0.0, 1.0};
  recording.series.q = {{0.7, 0.7}, {0.0, 0.0}};
  recording.series.dq = {{2.0, -1.0}, {0.0, 0.0}};
  recording.series.ddq = recording.series.measured = recording.series.modelled = {{0.0, 0.0}, {0.0, 0.0}};
  id.train.push_back(recording);
  return id;
}

ModelDescription file() { return read_model(VERIDYN_SOURCE_DIR "/data/robots/planar-2r.yaml").description(); }

TEST(FrictionCurves, AreTheSumOfTheEffectsWithTheirInterval) {
  const std::vector<FrictionCurve> curves = friction_curves(identified(file()));
  ASSERT_EQ(curves.size(), 1U);  // the elbow never moved
  const FrictionCurve& c = curves.front();
  EXPECT_NEAR(c.velocity.maxCoeff(), 2.0, 1e-12);
  for (Eigen::Index k = 0; k < c.velocity.size(); ++k) {
    const double v = c.velocity[k];
    EXPECT_NEAR(c.torque[k], 0.8 * v + std::copysign(1.2, v), 1e-9) << v;
    EXPECT_NEAR(c.half_width[k], 1.96 * 0.1 * std::abs(v), 1e-9) << v;  // 95 % of a normal distribution
  }
  EXPECT_NEAR(c.at(0.5), 0.8 * 0.5 + 1.2, 1e-6);
}

// Where the model has the scatter over clusters, the parameters' errors are not independent: those of viscous and
// Coulomb friction take each other off here. A parameter that the recordings tell in a combination alone has its
// deviation, if that is known.
TEST(FrictionCurves, HaveTheIntervalOfTheParameterScatter) {
  ModelDescription d = file();
  IdentifiedBase base;
  base.clusters = 3;
  const auto add = [&base](const std::string& name, const Eigen::Vector3d& scatter) {
    IdentifiedParameter p;
    p.name = name;
    p.combination[name] = 1.0;
    p.scatter = scatter;
    base.parameters.push_back(p);
  };
  const Eigen::Vector3d viscous(0.2, -0.1, 0.05), coulomb(-0.1, 0.3, 0.02);
  add("viscous_friction(shoulder).coefficient", viscous);
  add("coulomb_friction(shoulder).level", coulomb);
  d.identified = base;
  Identification id = identified(d);
  const auto expect = [](const FrictionCurve& c, const Eigen::Vector3d& at_speed, const Eigen::Vector3d& at_side, double own) {
    for (Eigen::Index k = 0; k < c.velocity.size(); ++k) {
      const double v = c.velocity[k];
      EXPECT_NEAR(c.half_width[k], 1.96 * std::hypot((v * at_speed + std::copysign(1.0, v) * at_side).norm(), own * v), 1e-9) << v;
    }
  };
  expect(friction_curves(id).at(0), viscous, coulomb, 0.0);
  d.identified->parameters[0].combination["Lzz_upper"] = 2.0;
  Identification combined = identified(d);
  expect(friction_curves(combined).at(0), Eigen::Vector3d::Zero(), coulomb, 0.1);
  combined.parameter_deviations.setConstant(std::nan(""));
  expect(friction_curves(combined).at(0), Eigen::Vector3d::Zero(), coulomb, 0.0);
}

// Between its speeds a curve is straight, and beyond them it stays.
TEST(FrictionCurves, AreLinearBetweenSpeedsAndConstantBeyondTheirEnds) {
  const FrictionCurve c{{0}, Eigen::Vector3d(-1.0, 1.0, 3.0), Eigen::Vector3d(-2.0, 2.0, 8.0), Eigen::Vector3d::Zero()};
  EXPECT_EQ(c.at(-9.0), -2.0);
  EXPECT_EQ(c.at(-1.0), -2.0);
  EXPECT_EQ(c.at(0.0), 0.0);
  EXPECT_EQ(c.at(2.0), 5.0);
  EXPECT_EQ(c.at(3.0), 8.0);
  EXPECT_EQ(c.at(9.0), 8.0);
}

TEST(FrictionCurves, OfAModelWithoutFrictionAreEmpty) {
  ModelDescription d = file();
  d.effects.clear();
  EXPECT_TRUE(friction_curves(identified(std::move(d))).empty());
}

// Friction that depends on position is that of the mean position, counted from where the effect's axis has its zero.
TEST(FrictionCurves, AreEvaluatedAtTheMeanPosition) {
  ModelDescription d = file();
  EffectTerm term = d.effects.front();
  term.effect = "position_dependent_viscosity";
  term.values = {{"slope", 0.3}, {"curvature", 0.0}, {"centre", 0.1}};
  term.axis.offset = 0.25;
  d.effects = {term};
  const std::vector<FrictionCurve> curves = friction_curves(identified(std::move(d)));
  ASSERT_EQ(curves.size(), 1U);
  const FrictionCurve& c = curves.front();
  for (Eigen::Index k = 0; k < c.velocity.size(); ++k)
    EXPECT_NEAR(c.torque[k], 0.3 * (0.7 + 0.25 - 0.1) * c.velocity[k], 1e-9) << c.velocity[k];
}

}  // namespace
}  // namespace veridyn
