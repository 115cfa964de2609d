#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "effects/effect_support.hpp"

namespace veridyn {
namespace {

constexpr double kEps = 1e-14;

TEST(RigidFriction, ColumnsAreVelocityItsSignAndAConstant) {
  EXPECT_EQ(columns_of("viscous_friction", moving(0.3, -0.7))[0], -0.7);
  EXPECT_EQ(columns_of("torque_offset", moving(0.3, -0.7))[0], 1.0);
  EXPECT_EQ(columns_of("coulomb_friction", moving(0.3, -0.7))[0], -1.0);
  AxisSample x;
  x.dds = 3.5;
  EXPECT_EQ(columns_of("rotor_inertia", x)[0], 3.5);
}

TEST(CoulombFriction, IsLinearThroughRest) {
  for (const double share : {-1.0, -0.25, 0.0, 1e-5, 0.5, 1.0}) {
    EXPECT_NEAR(columns_of("coulomb_friction", moving(0, share * kRestSpeed))[0], share, kEps);
  }
}

// 2 / (1 + exp(-a v)) - 1 = tanh(a v / 2).
TEST(CoulombFriction, WithASlopeIsTheSigmoidOfTheThesisErrata) {
  for (const double a : {20.0, 300.0}) {
    for (const double v : {-2.0, -0.01, 0.0, 1e-8, 0.003, 0.4}) {
      const double sigmoid = 2.0 / (1.0 + std::exp(-a * v)) - 1.0;
      EXPECT_NEAR(columns_of("coulomb_friction", moving(0, v), {{"slope", a}})[0], sigmoid, kEps);
    }
  }
}

TEST(JointSpring, PullsBackToItsRest) {
  EXPECT_EQ(columns_of("joint_spring", moving(0.4, 0))[0], 0.4);
}

TEST(JointSpring, OnALeverItsTorqueIsTheSlopeOfTheElasticEnergy) {
  const double r = 0.03;
  const double a = 0.11;
  const double rest = 0.07;
  const double angle = 0.2;
  const auto energy = [&](double s) {
    const double length = std::sqrt(r * r + a * a - 2 * r * a * std::cos(s + angle));
    return 0.5 * (length - rest) * (length - rest);
  };
  const double h = std::cbrt(2.2e-16);
  for (double s = -3.0; s < 3.0; s += 0.37) {
    const double column =
        columns_of("joint_spring", moving(s, 0),
                   {{"lever", r}, {"anchor", a}, {"rest_length", rest}, {"angle", angle}})[0];
    EXPECT_NEAR(column, (energy(s + h) - energy(s - h)) / (2 * h), 1e-11) << s;
  }
}

TEST(JointSpring, ItsTorqueIsZeroWherePinAndAnchorCoincide) {
  EXPECT_EQ(columns_of("joint_spring", moving(0, 0), {{"lever", 0.1}, {"anchor", 0.1}})[0], 0.0);
}

TEST(EndStop, ActsAsASpringBeyondItsEndAndIsZeroElsewhere) {
  const auto at = [](double s, double side) {
    return columns_of("end_stop", moving(s, 0.3), {{"centre", 0.2}, {"reach", 0.5}, {"side", side}})[0];
  };
  EXPECT_EQ(at(0.6, 1.0), 0.0);
  EXPECT_NEAR(at(1.0, 1.0), 0.3, kEps);
  EXPECT_EQ(at(1.0, -1.0), 0.0);
  EXPECT_NEAR(at(-0.7, -1.0), -0.4, kEps);  // the motor pulls where the stop pushes upwards
}

TEST(StribeckFriction, DecaysAsAGaussianOfVelocity) {
  const std::map<std::string, double> shape{{"velocity", 0.2}};
  EXPECT_NEAR(columns_of("stribeck_friction", moving(0, 0.2), shape)[0], std::exp(-1.0), kEps);
  EXPECT_NEAR(columns_of("stribeck_friction", moving(0, -0.4), shape)[0], -std::exp(-4.0), kEps);
  EXPECT_EQ(columns_of("stribeck_friction", moving(0, 0.0), shape)[0], 0.0);
  EXPECT_NEAR(columns_of("stribeck_friction", moving(0, kRestSpeed), {{"velocity", 1.0}})[0], 1.0,
              2 * kRestSpeed * kRestSpeed);
}

TEST(AsymmetricFriction, TheParameterIsForwardMinusBackwardFriction) {
  const EffectColumns forwards = columns_of("asymmetric_friction", moving(0, 0.6));
  const EffectColumns backwards = columns_of("asymmetric_friction", moving(0, -0.6));
  // Friction is positive in the direction of motion: its size backwards is minus the torque.
  EXPECT_NEAR(forwards[0] - -backwards[0], 1.0, kEps);
  EXPECT_NEAR((forwards[1] - -backwards[1]) / 0.6, 1.0, kEps);
  EXPECT_EQ(columns_of("asymmetric_friction", moving(0, 0))[0], 0.0);
}

// Columns 1 (torque_offset), |sign(ds)| / 2, |ds| / 2: the first two are apart at rest only.
TEST(AsymmetricFriction, IsCollinearWithAnOffsetUnlessSomeSamplesAreAtRest) {
  const auto rank = [](const std::vector<double>& speeds) {
    MatrixXd A(speeds.size(), 3);
    for (Eigen::Index k = 0; k < A.rows(); ++k) {
      const EffectColumns row =
          columns_of("asymmetric_friction", moving(0, speeds[k]));
      A.row(k) << 1.0, row[0], row[1];
    }
    const Eigen::Matrix3d G =
        A.transpose() * A;  // singular if and only if the columns are dependent
    return std::abs(G.determinant()) > 1e-9 ? 3 : 2;
  };
  EXPECT_EQ(rank({-0.5, -0.2, 0.1, 0.3, 0.8}), 2);
  EXPECT_EQ(rank({-0.5, -0.2, 0.0, 0.3, 0.8}), 3);
}

TEST(PositionDependentFriction, LevelAndViscosityAreQuadraticInThePosition) {
  for (const double ds : {-0.3, 0.3}) {
    const EffectColumns level =
        columns_of("position_dependent_friction", moving(0.7, ds), {{"centre", 0.2}});
    EXPECT_NEAR(level[0], std::copysign(0.5, ds), kEps);
    EXPECT_NEAR(level[1], std::copysign(0.25, ds), kEps);
    const EffectColumns viscosity =
        columns_of("position_dependent_viscosity", moving(0.7, ds), {{"centre", 0.2}});
    EXPECT_NEAR(viscosity[0], 0.5 * ds, kEps);
    EXPECT_NEAR(viscosity[1], 0.25 * ds, kEps);
  }
}

TEST(LoadDependentFriction, OpposesTheMotionWhicheverWayTheLoadPulls) {
  AxisSample x = moving(0, -0.4);
  for (const double load : {-12.0, 12.0}) {
    x.load = load;
    EXPECT_EQ(columns_of("load_dependent_friction", x)[0], -12.0);
  }
}

TEST(SpeedLaws, DragIsQuadraticAndSublinearFrictionAPowerBelowOne) {
  EXPECT_NEAR(columns_of("quadratic_drag", moving(0, -0.3))[0], -0.09, kEps);
  EXPECT_NEAR(columns_of("sublinear_viscous", moving(0, -0.25))[0], -0.5, kEps);
  EXPECT_NEAR(columns_of("sublinear_viscous", moving(0, 2.0), {{"exponent", 0.3}})[0],
              std::pow(2.0, 0.3), kEps);
  EXPECT_EQ(columns_of("sublinear_viscous", moving(0, 0))[0], 0.0);
  EXPECT_NEAR(columns_of("sublinear_viscous", moving(0, 0.5 * kRestSpeed))[0],
              0.5 * std::sqrt(kRestSpeed), kEps);
  // Continuous where the straight line through rest ends.
  const double at = columns_of("sublinear_viscous", moving(0, kRestSpeed))[0];
  EXPECT_NEAR(columns_of("sublinear_viscous", moving(0, kRestSpeed * (1 - 1e-9)))[0], at, 1e-9);
  EXPECT_NEAR(columns_of("sublinear_viscous", moving(0, kRestSpeed * (1 + 1e-9)))[0], at, 1e-9);
}

TEST(TorqueRipple, RepeatsEveryTurnDividedByItsOrder) {
  const std::map<std::string, double> shape{{"order", 202.0}};
  for (const double s : {-1.3, 0.0, 0.4}) {
    const EffectColumns row = columns_of("torque_ripple", moving(s, 0), shape);
    const EffectColumns next = columns_of("torque_ripple", moving(s + 2 * M_PI / 202, 0), shape);
    const EffectColumns quarter = columns_of("torque_ripple", moving(s + M_PI / 404, 0), shape);
    for (const int c : {0, 1}) EXPECT_NEAR(row[c], next[c], 1e-12);
    EXPECT_NEAR(quarter[1], row[0], 1e-12);  // sin a quarter of a wave later is cos
    EXPECT_NEAR(row[0] * row[0] + row[1] * row[1], 1.0, kEps);
  }
}

TEST(CableCoupling, DependsOnPositionSquareAndSignOfVelocityOfItsSource) {
  AxisSample x = moving(5.0, 6.0);
  x.from_s = -0.2;
  x.from_ds = -0.1;
  const EffectColumns row = columns_of("cable_coupling", x);
  EXPECT_EQ(row[0], -0.2);
  EXPECT_NEAR(row[1], 0.04, kEps);
  EXPECT_EQ(row[2], -1.0);
}

// T_k(cos a) = cos(k a).
TEST(PositionForce, ColumnsAreChebyshevPolynomialsOverItsRange) {
  const std::map<std::string, double> shape{{"centre", 0.1}, {"half_range", 0.4}};
  for (double a = 0.0; a <= M_PI; a += 0.1) {
    const EffectColumns row =
        columns_of("position_force", moving(0.1 + 0.4 * std::cos(a), 0), shape);
    for (int k = 2; k <= 5; ++k) EXPECT_NEAR(row[k - 2], std::cos(k * a), 1e-13);
  }
}

TEST(PositionForce, StaysConstantOutsideItsRange) {
  const std::map<std::string, double> shape{{"centre", 0.1}, {"half_range", 0.4}};
  const EffectColumns end = columns_of("position_force", moving(-0.3, 0), shape);
  const EffectColumns far = columns_of("position_force", moving(-7.0, 0), shape);
  for (int c = 0; c < 4; ++c) EXPECT_NEAR(end[c], far[c], 1e-13);
}

TEST(SlowEffects, DriftGrowsLinearlyAndWarmUpDecaysExponentially) {
  AxisSample x = moving(0, -0.5);
  x.time = 120.0;
  EXPECT_EQ(columns_of("torque_drift", x)[0], 120.0);
  const EffectColumns cold = columns_of("warm_up", x, {{"time_constant", 40.0}});
  EXPECT_NEAR(cold[0], -std::exp(-3.0), kEps);
  EXPECT_NEAR(cold[1], -0.5 * std::exp(-3.0), kEps);
}

class FrictionWithoutMemory : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Effect, FrictionWithoutMemory,
                         testing::Values("viscous_friction", "coulomb_friction",
                                         "stribeck_friction", "load_dependent_friction",
                                         "quadratic_drag", "sublinear_viscous", "warm_up"),
                         effect_case);

TEST_P(FrictionWithoutMemory, DissipatesPowerAtEverySampleForAnyAllowedParameters) {
  const auto parameters = find_effect(GetParam()).parameters();
  for (const AxisSample& x : random_samples(8)) {
    const EffectColumns row = columns_of(GetParam(), x);
    for (size_t c = 0; c < parameters.size(); ++c) {
      EXPECT_EQ(parameters[c].sign, ParameterSign::kNonnegative);
      EXPECT_GE(row[c] * x.ds, 0.0) << parameters[c].name;
    }
  }
}

TEST_P(FrictionWithoutMemory, IsAnOddFunctionOfVelocity) {
  for (AxisSample x : random_samples(9)) {
    const EffectColumns row = columns_of(GetParam(), x);
    x.ds = -x.ds;
    const EffectColumns mirrored = columns_of(GetParam(), x);
    for (size_t c = 0; c < find_effect(GetParam()).parameters().size(); ++c)
      EXPECT_EQ(mirrored[c], -row[c]);
  }
}

}  // namespace
}  // namespace veridyn
