#include <gtest/gtest.h>

#include <cmath>

#include "support/near.hpp"
#include "support/random.hpp"
#include "support/sample_arms.hpp"
#include "excitation/search/base_regressor.hpp"
#include "veridyn/excitation/fourier_trajectory.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

constexpr double kFrequency = 0.2;
constexpr int kInstants = 40;

// A motion and f(x) = <weights, Gram matrix> along it.
struct Case {
  explicit Case(const Model& model, unsigned seed) : arm(model), regressor(model, 0.02) {
    Random random(seed);
    const int n = arm.joints();
    const auto matrix = [&](int rows, int columns, double size) -> MatrixXd {
      const VectorXd v = random.vector(rows * columns, -size, size);
      return Eigen::Map<const MatrixXd>(v.data(), rows, columns);
    };
    motion = FourierTrajectory(kFrequency, matrix(n, 3, 0.6), matrix(n, 3, 0.6),
                               random.vector(n, -0.3, 0.3))
                 .samples(period_instants(kFrequency, kInstants));
    const MatrixXd any = matrix(regressor.size(), regressor.size(), 1.0);
    const VectorXd inverse = regressor.scale().cwiseInverse();
    weights = inverse.asDiagonal() * (any + any.transpose()) * inverse.asDiagonal();
  }
  double value(const MotionSamples& at) const {
    return weights.cwiseProduct(regressor.gram(at)).sum();
  }
  double central_difference(int direction, Eigen::Index row, double h) const {
    const int n = arm.joints();
    MatrixXd MotionSamples::*part = direction < n       ? &MotionSamples::q
                                    : direction < 2 * n ? &MotionSamples::dq
                                                        : &MotionSamples::ddq;
    MotionSamples above = motion;
    MotionSamples below = motion;
    (above.*part)(row, direction % n) += h;
    (below.*part)(row, direction % n) -= h;
    return (value(above) - value(below)) / (2.0 * h);
  }

  Model arm;
  BaseRegressor regressor;
  MotionSamples motion;
  MatrixXd weights;
};

void expect_gradient(const Case& c) {
  const MatrixXd slopes = c.regressor.gradient(c.motion, c.weights);
  const double size = slopes.cwiseAbs().maxCoeff();
  ASSERT_GT(size, 0.0);
  for (int d = 0; d < 3 * c.arm.joints(); ++d) {
    for (const Eigen::Index row : {0, 7, 23, kInstants - 1}) {
      // Two steps: their combination is of fourth order (Richardson).
      const double wide = c.central_difference(d, row, 4e-4);
      const double close = c.central_difference(d, row, 2e-4);
      EXPECT_NEAR(slopes(row, d), (4.0 * close - wide) / 3.0, 1e-6 * size) << d << " " << row;
    }
  }
}

class GradientOf : public testing::TestWithParam<std::string> {};

TEST_P(GradientOf, TheCriterionAgreesWithCentralDifferences) {
  expect_gradient(Case(read_model(GetParam()), 5));
}

INSTANTIATE_TEST_SUITE_P(Robots, GradientOf,
                         testing::Values("planar-2r", "scara", "psm-3dof", "psm-wrist", "ur10e",
                                         "kuka-lwr4"),
                         sample_arm_name);

Model with_effect(const std::string& effect, const std::map<std::string, double>& values) {
  ModelDescription arm = elbow_6r().description();
  EffectTerm term;
  term.effect = effect;
  term.axis.coefficients = VectorXd::Zero(6);
  term.axis.coefficients[1] = 1.2;
  term.axis.coefficients[2] = -0.7;
  term.values = values;
  arm.effects = {term};
  return Model(std::move(arm));
}

// Effects are seen through differences of their own; those with a memory through the past.
TEST(Gradient, OfEveryKindOfEffectAgreesWithCentralDifferences) {
  expect_gradient(Case(with_effect("stribeck_friction", {{"velocity", 0.3}}), 6));
  expect_gradient(Case(with_effect("joint_spring", {}), 7));
  expect_gradient(Case(with_effect("position_dependent_friction", {{"centre", 0.2}}), 8));
  expect_gradient(Case(with_effect("presliding_hysteresis", {{"distance", 0.3}}), 9));
  expect_gradient(Case(with_effect("quadratic_drag", {}), 10));
}

// The base columns span all columns: nothing of the regressor is lost.
TEST_P(GradientOf, BaseColumnsHaveANonsingularOrthogonalBasis) {
  const BaseRegressor r(read_model(GetParam()));
  EXPECT_EQ(r.orthogonal_basis().rows(), r.size());
  EXPECT_TRUE(r.orthogonal_basis().allFinite());
  EXPECT_GT(r.orthogonal_basis().diagonal().cwiseAbs().minCoeff(), 0.0);
}

}  // namespace
}  // namespace veridyn
