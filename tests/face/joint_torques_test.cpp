#include <gtest/gtest.h>

#include <cmath>

#include "support/near.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/simulation/plausible_model.hpp"
#include "veridyn/veridyn.hpp"

namespace veridyn {
namespace {

ModelDescription planar() {
  ModelDescription d = plausible_model(read_model("planar-2r"), 3).arm.description();
  d.effects.clear();
  return d;
}

EffectTerm term(const std::string& effect, const std::map<std::string, double>& values) {
  EffectTerm out;
  out.effect = effect;
  out.axis.coefficients = Eigen::Vector2d(1.0, 0.0);
  out.values = values;
  return out;
}

TEST(JointTorques, AreRigidBodiesPlusEffectsInClosedForm) {
  ModelDescription d = planar();
  const VectorXd q = Eigen::Vector2d(0.3, -0.4), dq = Eigen::Vector2d(0.7, 0.2),
                 ddq = Eigen::Vector2d(-1.0, 2.0);
  const VectorXd rigid = inverse_dynamics(Model(d), q, dq, ddq);
  d.effects = {term("viscous_friction", {{"coefficient", 0.5}}),
               term("coulomb_friction", {{"level", 0.25}}),
               term("rotor_inertia", {{"inertia", 0.1}})};
  const VectorXd effects = Eigen::Vector2d(0.5 * 0.7 + 0.25 - 0.1, 0.0);
  EXPECT_TRUE(near(joint_torques(Model(d), q, dq, ddq), VectorXd(rigid + effects), 1e-12));
}

// Dahl friction along a way that turns round, whatever the rows: z is a function of the path.
TEST(JointTorques, HysteresisDependsOnThePathAndNotOnTheRows) {
  ModelDescription d = planar();
  const double level = 0.4, distance = 0.02;
  d.effects = {term("presliding_hysteresis", {{"level", level}, {"distance", distance}})};
  const Model arm(d);
  constexpr int kRows = 401;
  MotionSamples m{VectorXd::LinSpaced(kRows, 0.0, 4.0), MatrixXd::Zero(kRows, 2),
                  MatrixXd::Zero(kRows, 2), MatrixXd::Zero(kRows, 2)};
  for (int k = 0; k < kRows; ++k) {
    const double t = m.time[k];
    m.q(k, 0) = 0.1 * std::sin(0.5 * M_PI * t);
    m.dq(k, 0) = 0.05 * M_PI * std::cos(0.5 * M_PI * t);
    m.ddq(k, 0) = -0.025 * M_PI * M_PI * std::sin(0.5 * M_PI * t);
  }
  const MatrixXd tau = joint_torques(arm, m);
  const TorqueRegressor bodies(arm);
  MatrixXd rigid;
  bodies.torques(m.q, m.dq, m.ddq, *arm.inertial_values(), rigid);
  // Forward to 0.1 at t = 1, back to -0.1 at t = 3.
  const double up = 1.0 - std::exp(-0.1 / distance);
  const double down = -1.0 + (up + 1.0) * std::exp(-0.2 / distance);
  EXPECT_NEAR(tau(100, 0) - rigid(100, 0), level * up, 1e-3 * level);
  EXPECT_NEAR(tau(300, 0) - rigid(300, 0), level * down, 1e-3 * level);
}

TEST(JointTorques, RejectMotionsOfTheWrongSize) {
  ModelDescription d = planar();
  d.effects = {term("viscous_friction", {})};
  const VectorXd two = VectorXd::Zero(2), three = VectorXd::Zero(3);
  EXPECT_THROW(joint_torques(Model(d), two, two, two), InvalidInput);
  EXPECT_THROW(joint_torques(Model(planar()), three, three, three), InvalidInput);
  EXPECT_THROW(joint_torques(read_model("psm-3dof"), three, three, three), InvalidInput);
}

}  // namespace
}  // namespace veridyn
