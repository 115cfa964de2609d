#include "regressor/effect_along.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "regressor/arm_columns.hpp"
#include "regressor/random_states.hpp"
#include "regressor/stacked_columns.hpp"
#include "support/near.hpp"
#include "support/random.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/identification/regressor_columns.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/identification/base_parameters.hpp"

namespace veridyn {
namespace {

Model with_effect(const Model& arm, const std::string& effect, int joint,
                  std::map<std::string, double> values = {}) {
  ModelDescription d = arm.description();
  EffectTerm term;
  term.effect = effect;
  term.axis.coefficients = VectorXd::Unit(arm.joints(), joint);
  term.values = std::move(values);
  d.effects.push_back(std::move(term));
  return Model(std::move(d));
}

// Friction of the load is the load times the direction: the load is M ddq + C dq + g, one number
// per joint, found here by inverse dynamics state by state.
TEST(EffectAlong, TheLoadOfFrictionIsTheRigidBodyTorque) {
  const Model arm = with_effect(read_model("planar-2r"), "load_dependent_friction", 1);
  const MotionSamples states = random_states(arm, 50);
  const TorqueRegressor bodies(arm);
  const MatrixXd load = rigid_load(arm, bodies, states);
  const BoundEffect effect(arm, arm.effects().back());
  const MatrixXd columns = columns_along(effect, states, load, 0.0);
  for (Eigen::Index k = 0; k < states.rows(); ++k) {
    const VectorXd tau = inverse_dynamics(arm, states.q.row(k).transpose(),
                                          states.dq.row(k).transpose(),
                                          states.ddq.row(k).transpose());
    EXPECT_TRUE(near(load.row(k).transpose(), tau, 1e-10 * (1.0 + tau.norm()))) << k;
    const double direction = states.dq(k, 1) > 0.0 ? 1.0 : -1.0;
    EXPECT_NEAR(columns(k, 0), direction * std::abs(tau[1]), 1e-10 * (1.0 + tau.norm())) << k;
  }
}

// An identification without a filter and an excitation have one regressor, memories included.
TEST(ArmColumns, EqualTheRegressorRowsOfAnIdentification) {
  Model arm = with_effect(read_model("planar-2r"), "presliding_hysteresis", 0);
  arm = with_effect(arm, "load_dependent_friction", 1, {{"distance", 0.01}});
  arm = with_effect(arm, "transmission_compliance", 0);
  const int rows = 200;
  Segment s;
  s.dt = 0.01;
  s.time = VectorXd::LinSpaced(rows, 0.0, 0.01 * (rows - 1));
  s.q.resize(rows, 2);
  s.dq.resize(rows, 2);
  s.ddq.resize(rows, 2);
  for (int i = 0; i < 2; ++i) {
    const double w = 5.0 + 2.0 * i;
    s.q.col(i) = 0.3 * (w * s.time.array()).sin();
    s.dq.col(i) = 0.3 * w * (w * s.time.array()).cos();
    s.ddq.col(i) = -0.3 * w * w * (w * s.time.array()).sin();
  }
  s.tau = MatrixXd::Zero(rows, 2);
  s.use.assign(rows, 1);
  s.core_begin = 0;
  s.core_end = rows;
  PreprocessingOptions unfiltered;
  unfiltered.cutoff = 0.0;
  const RegressorColumns columns(arm, unfiltered);
  const MotionSamples motion{s.time, s.q, s.dq, s.ddq};
  const StackedColumns all(2, arm_columns(arm, 0.0));
  const MatrixXd W = all.stacked(motion);
  ASSERT_EQ(W.cols(), static_cast<Eigen::Index>(columns.parameters().size()));
  const std::vector<JointRows> joints = columns.rows(s);
  // A prediction, which does without columns of bodies, is the rows times the values.
  ASSERT_TRUE(arm.inertial_values().has_value());
  const VectorXd values = Random(17).vector(static_cast<int>(W.cols()), -1.0, 1.0);
  const MatrixXd modelled = columns.predict(s, values).modelled;
  for (int i = 0; i < 2; ++i) {
    const JointRows& own = joints[i];
    for (Eigen::Index k = 0; k < own.A.rows(); ++k) {
      double sum = 0.0;
      for (size_t c = 0; c < own.parameters.size(); ++c)
        sum += own.A(k, static_cast<Eigen::Index>(c)) * values[own.parameters[c]];
      const auto row = static_cast<Eigen::Index>(std::lround(own.time[k] / s.dt));
      ASSERT_NEAR(modelled(row, i), sum, 1e-10 * (1.0 + modelled.col(i).norm())) << i << " " << k;
    }
    ASSERT_EQ(own.A.rows() % 1, 0);
    for (size_t c = 0; c < own.parameters.size(); ++c) {
      for (Eigen::Index k = 0; k < own.A.rows(); ++k) {
        const auto row = static_cast<Eigen::Index>(std::lround(own.time[k] / s.dt));
        const double expected = W(i * rows + row, own.parameters[c]);
        ASSERT_NEAR(own.A(k, static_cast<Eigen::Index>(c)), expected, 1e-9 * (1 + std::abs(expected)))
            << i << " " << k << " " << columns.parameters()[own.parameters[c]].name;
      }
    }
  }
}

// A memory that starts afresh at every state would have no column and drop out of the base.
TEST(BaseParametersOfAnArm, IncludeEffectsWithAMemory) {
  const Model arm = with_effect(read_model("psm-3dof"), "presliding_hysteresis", 2);
  const BaseParameters base = identifiable_base_parameters(arm);
  EXPECT_EQ(std::count(base.names.begin(), base.names.end(),
                       "presliding_hysteresis(insertion).level"),
            1);
}

TEST(RandomStates, AreReproducibleAndKeepGivenJointsAtRest) {
  const Model arm = read_model("psm-3dof");
  const MotionSamples a = random_states(arm, 30, 5);
  const MotionSamples b = random_states(arm, 30, 5);
  EXPECT_EQ(a.q, b.q);
  EXPECT_NE(a.q, random_states(arm, 30, 6).q);
  const MotionSamples still = random_states(arm, 30, 5, {"pitch"});
  EXPECT_EQ(still.dq.col(1).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ(still.ddq.col(1).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ(still.q.col(0), a.q.col(0));
}

}  // namespace
}  // namespace veridyn
