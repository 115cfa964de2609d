#include "veridyn/regressor/standard_parameters.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/refusal.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(StandardParameters, SurviveARoundTripThroughAnArm) {
  const Model arm = read_model("planar-2r");
  const VectorXd values = standard_values(arm) * 1.5;
  VectorXd deviations = VectorXd::Constant(values.size(), kNan);
  deviations[values.size() - 1] = 0.25;
  const Model other = with_values(arm, values, deviations);
  EXPECT_EQ(standard_values(other), values);
  EXPECT_EQ(other.effects().back().deviations.at("level"), 0.25);
  EXPECT_TRUE(other.effects().front().deviations.empty());
  EXPECT_TRUE(other.frames()[0].body->std_phi.has_value());
  // Without deviations there are none, and none of the old ones are left.
  const Model without = with_values(other, values, VectorXd());
  EXPECT_TRUE(without.effects().back().deviations.empty());
  EXPECT_FALSE(without.frames()[0].body->std_phi.has_value());
}

TEST(StandardParameters, OfTheWrongNumberAreRefused) {
  const Model arm = read_model("planar-2r");
  const Eigen::Index count = standard_values(arm).size();
  for (const Eigen::Index wrong : {Eigen::Index{0}, count - 1, count + 1}) {
    EXPECT_TRUE(refuses_with("expected " + std::to_string(count), [&] { with_values(arm, VectorXd::Zero(wrong), VectorXd()); })) << wrong;
  }
  EXPECT_TRUE(refuses_with("deviations", [&] { with_values(arm, VectorXd::Zero(count), VectorXd::Zero(count - 1)); }));
}

TEST(StandardParameters, OfBodiesWithoutValuesAreRefused) {
  EXPECT_TRUE(refuses_with("bodies without mass", [] { standard_values(read_model("psm-3dof")); }));
}

}  // namespace
}  // namespace veridyn
