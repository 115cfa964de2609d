#include "veridyn/excitation/excitation.hpp"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <cmath>

#include "support/near.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "excitation/search/base_regressor.hpp"
#include "kinematics/motion_limits.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn {
namespace {

ExcitationOptions small_search() {
  ExcitationOptions options;
  options.starts = 2;
  options.iterations = 15;
  return options;
}

class ExcitationOf : public testing::TestWithParam<std::string> {};

// The grid is denser than any recording and does not match that of the search.
TEST_P(ExcitationOf, KeepsWithinTheLimitsBetweenSamples) {
  const Model arm = read_model(GetParam());
  ExcitationOptions options = small_search();
  options.limit_share = 0.9;
  const Excitation e = optimise_excitation(arm, options);
  const MotionLimits limits = motion_limits(arm);
  const MotionSamples fine = e.trajectory.samples(period_instants(e.trajectory.frequency(), 30011));
  for (int i = 0; i < arm.joints(); ++i) {
    const double share = 0.9 * (1.0 + 1e-9);
    const double edge = 0.05 * (limits.upper[i] - limits.lower[i]);
    EXPECT_GE(fine.q.col(i).minCoeff(), limits.lower[i] + edge * (1.0 - 1e-9)) << i;
    EXPECT_LE(fine.q.col(i).maxCoeff(), limits.upper[i] - edge * (1.0 - 1e-9)) << i;
    EXPECT_LE(fine.dq.col(i).cwiseAbs().maxCoeff(), share * limits.velocity[i]) << i;
    EXPECT_LE(fine.ddq.col(i).cwiseAbs().maxCoeff(), share * limits.acceleration[i]) << i;
  }
}

TEST_P(ExcitationOf, StartsAndStopsAtRest) {
  const Excitation e = optimise_excitation(read_model(GetParam()), small_search());
  EXPECT_GE(e.periods, 2);
  const MotionSamples m = e.trajectory.motion(e.periods, 200.0);
  for (const Eigen::Index row : {Eigen::Index{0}, m.rows() - 1}) {
    EXPECT_TRUE(near(m.dq.row(row), MatrixXd::Zero(1, m.joints()), 1e-10));
    EXPECT_TRUE(near(m.ddq.row(row), MatrixXd::Zero(1, m.joints()), 1e-9));
  }
}

INSTANTIATE_TEST_SUITE_P(Robots, ExcitationOf, testing::Values("planar-2r", "scara", "psm-3dof"),
                         sample_arm_name);

TEST(Excitation, TheSameSeedGivesTheSameMotionOnAnyNumberOfThreads) {
  const Model arm = read_model("scara");
  ExcitationOptions options = small_search();
  options.threads = 1;
  const Excitation one = optimise_excitation(arm, options);
  options.threads = 2;
  const Excitation two = optimise_excitation(arm, options);
  EXPECT_TRUE(near(one.trajectory.a(), two.trajectory.a(), 0.0));
  EXPECT_TRUE(near(one.trajectory.q0(), two.trajectory.q0(), 0.0));
  options.seed = 2;
  EXPECT_GT((optimise_excitation(arm, options).trajectory.a() - one.trajectory.a()).norm(), 1e-3);
}

TEST(Excitation, EverySolverImprovesOnARandomMotion) {
  const Model arm = read_model("planar-2r");
  for (const auto solver :
       {ExcitationSolver::kInteriorPoint, ExcitationSolver::kRandom}) {
    ExcitationOptions options = small_search();
    options.criterion = ExcitationCriterion::kCondition;
    options.solver = solver;
    options.iterations = 60;
    const Excitation e = optimise_excitation(arm, options);
    EXPECT_EQ(e.status, ExcitationStatus::kDone) << name_of(solver);
    EXPECT_LT(e.condition_number, 0.9 * e.start_condition_number) << name_of(solver);
  }
}

TEST(Excitation, EachCriterionGivesTheMotionBestByItself) {
  const Model arm = read_model("psm-3dof");
  ExcitationOptions options = small_search();
  options.iterations = 100;
  options.criterion = ExcitationCriterion::kCondition;
  const Excitation c = optimise_excitation(arm, options);
  options.criterion = ExcitationCriterion::kDOptimal;
  const Excitation d = optimise_excitation(arm, options);
  EXPECT_GT(d.log_determinant, c.log_determinant);
  EXPECT_LT(c.condition_number, d.condition_number);
  options.criterion = ExcitationCriterion::kCondition;
  options.scaling = ColumnScaling::kNone;
  const Excitation plain = optimise_excitation(arm, options);
  EXPECT_LT(plain.plain_condition_number, c.plain_condition_number);
}

// Thesis table 5.1 of optimised condition numbers, with the margins that a supervisor needs; one
// search is enough for these two of six.
TEST(Excitation, ConditionNumbersAreNoWorseThanThoseOfTheThesis) {
  ExcitationOptions options;
  options.criterion = ExcitationCriterion::kCondition;
  options.starts = 1;
  for (const auto& [frequency, thesis] : {std::pair{0.13, 128.74}, std::pair{0.20, 110.87}}) {
    options.frequency = frequency;
    const Excitation e = optimise_excitation(read_model("psm-3dof"), options);
    EXPECT_LT(e.condition_number, thesis) << frequency;
    EXPECT_EQ(e.base_parameters, 25);
    EXPECT_EQ(e.base.size(), 25u);
  }
}

// A supervisor stops an arm that is too fast to stop before a limit: from every instant of the motion
// q + dq / braking lies within the range, and speeds have a fiftieth to spare.
TEST(Excitation, LeavesTheBrakingMarginOfASafetySupervisor) {
  const Model arm = read_model("psm-3dof");
  const Excitation e = optimise_excitation(arm, small_search());
  const MotionLimits limits = motion_limits(arm);
  const MotionSamples fine = e.trajectory.samples(period_instants(e.trajectory.frequency(), 30011));
  for (int i = 0; i < arm.joints(); ++i) {
    const double room = 0.0025 * (limits.upper[i] - limits.lower[i]) * (1.0 - 1e-6);
    const VectorXd stop = fine.q.col(i) + fine.dq.col(i) / 30.0;
    EXPECT_GE(stop.minCoeff(), limits.lower[i] + room) << i;
    EXPECT_LE(stop.maxCoeff(), limits.upper[i] - room) << i;
    EXPECT_LE(fine.dq.col(i).cwiseAbs().maxCoeff(), 0.98 * (1.0 + 1e-9) * limits.velocity[i]) << i;
  }
}

// Scaled columns cancel the amplitude: with a condition number an arm may hardly move a joint, whose
// own columns are then as well conditioned as any. The default criterion uses every joint.
TEST(Excitation, TheDefaultCriterionMovesEveryJoint) {
  for (const char* robot : {"elbow-6r", "psm-3dof", "scara"}) {
    const Model arm = read_model(robot);
    ExcitationOptions options = small_search();
    options.iterations = 60;
    const Excitation e = optimise_excitation(arm, options);
    ASSERT_EQ(e.used.size(), static_cast<size_t>(arm.joints()));
    for (size_t i = 0; i < e.used.size(); ++i) {
      EXPECT_GT(std::max(e.used[i].range, e.used[i].velocity), kLittleUse) << robot << " " << i;
      EXPECT_LE(e.used[i].range, 1.0) << robot;
      EXPECT_LE(e.used[i].velocity, 1.0) << robot;
    }
    EXPECT_TRUE(e.warnings().empty()) << robot;
  }
}

// A joint that a limit holds is warned of with the name of the limit.
TEST(Excitation, AHardlyMovingJointIsReported) {
  ModelDescription d = read_model("planar-2r").description();
  d.coordinates[1].limits.acceleration = 1e-3;
  const Excitation e = optimise_excitation(Model(std::move(d)), small_search());
  const std::vector<std::string> warnings = e.warnings();
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("acceleration of " + e.joints[1]), std::string::npos) << warnings[0];
}

// A maker's file has no friction: the motion is designed for the arm that will be identified.
TEST(Excitation, IsDesignedWithFrictionIfTheRobotFileHasNone) {
  ModelDescription d = plausible_model(read_model("planar-2r"), 2).arm.description();
  d.effects.clear();
  d.values = RobotValues::kPrior;
  ExcitationOptions options = small_search();
  const int with = optimise_excitation(Model(d), options).base_parameters;
  options.friction = JointFriction::kFile;
  const Excitation bare = optimise_excitation(Model(d), options);
  EXPECT_GE(with, bare.base_parameters + 6);
  EXPECT_NE(bare.friction_remark.find("plain"), std::string::npos);
}

// A random motion with the same values and noise would leave twice the deviation and more.
TEST(Excitation, RelativeDeviationsAreBelowHalfOfARandomMotions) {
  const Model arm = read_model("psm-3dof");
  ExcitationOptions options = small_search();
  options.iterations = 60;
  options.valued = plausible_model(arm, 1).arm;
  options.criterion = ExcitationCriterion::kAOptimal;
  const Excitation best = optimise_excitation(arm, options);
  const Excitation d = optimise_excitation(arm, [&] {
    ExcitationOptions other = options;
    other.criterion = ExcitationCriterion::kDOptimal;
    return other;
  }());
  options.solver = ExcitationSolver::kRandom;
  options.iterations = 1;
  const Excitation random = optimise_excitation(arm, options);
  EXPECT_LT(best.prediction->mean_relative, 0.5 * random.prediction->mean_relative);
  EXPECT_LT(best.prediction->mean_relative, d.prediction->mean_relative);
  options.valued.reset();
  EXPECT_THROW(optimise_excitation(arm, options), InvalidInput);  // relative to what?
}

// What is recorded already need not be recorded again.
TEST(Excitation, GivenRecordingsReduceTheVariance) {
  const Model arm = read_model("psm-3dof");
  ExcitationOptions options = small_search();
  options.iterations = 60;
  options.criterion = ExcitationCriterion::kCondition;
  const Excitation first = optimise_excitation(arm, options);
  options.given = {first.trajectory.motion(first.periods, options.rate)};
  const Excitation second = optimise_excitation(arm, options);
  EXPECT_LT(second.condition_number_with_given, first.condition_number);
  EXPECT_EQ(first.condition_number_with_given, first.condition_number);
}

TEST(Excitation, AnInterruptedSearchKeepsAMotionWithinTheLimits) {
  ExcitationOptions options = small_search();
  options.iterations = 100000;
  options.threads = 1;
  int asked = 0;
  options.stop = [&asked] { return ++asked > 40; };
  const Excitation e = optimise_excitation(read_model("psm-3dof"), options);
  EXPECT_TRUE(e.interrupted);
  EXPECT_EQ(e.status, ExcitationStatus::kDone);
  for (const LimitMargin& m : e.margins) EXPECT_GE(m.margin, 0.0) << m.name;
}

// The regressor stacked and decomposed without any of the shortcuts.
TEST(Excitation, ConditionNumberEqualsThatOfTheScaledRegressor) {
  const Model arm = sample_arms().at("spherical_RRP");
  const BaseRegressor regressor(arm);
  Random random(3);
  const int rows = 60;
  MotionSamples m{VectorXd::LinSpaced(rows, 0.0, 1.0), MatrixXd(rows, 3), MatrixXd(rows, 3),
                  MatrixXd(rows, 3)};
  MatrixXd W(3 * rows, 10 * static_cast<Eigen::Index>(arm.bodies().size()));
  for (int k = 0; k < rows; ++k) {
    m.q.row(k) = random.vector(3, -1, 1).transpose();
    m.dq.row(k) = random.vector(3, -1, 1).transpose();
    m.ddq.row(k) = random.vector(3, -1, 1).transpose();
    W.middleRows(3 * k, 3) = torque_regressor(arm, m.q.row(k).transpose(), m.dq.row(k).transpose(),
                                              m.ddq.row(k).transpose());
  }
  const MatrixXd gram = regressor.gram(m);
  // Base columns are among the columns: their squared norms and products are found in W' W.
  const MatrixXd all = W.transpose() * W;
  for (int b = 0; b < regressor.size(); ++b) {
    EXPECT_LT((all.diagonal().array() - gram(b, b)).abs().minCoeff(), 1e-10 * gram(b, b));
  }
  const int rank = static_cast<int>(
      (Eigen::JacobiSVD<MatrixXd>(W).singularValues().array() > 1e-9 * W.norm()).count());
  EXPECT_EQ(regressor.size(), rank);
  MatrixXd scaled = gram;
  for (int b = 0; b < rank; ++b) {
    for (int c = 0; c < rank; ++c) scaled(b, c) /= std::sqrt(gram(b, b) * gram(c, c));
  }
  const VectorXd values = Eigen::JacobiSVD<MatrixXd>(scaled).singularValues();
  const double expected = std::sqrt(values[0] / values[rank - 1]);
  EXPECT_NEAR(scaled_condition_number(gram), expected, 1e-6 * expected);
}

TEST(Excitation, RefusesOptionsOutOfRange) {
  const Model arm = read_model("planar-2r");
  const auto with = [](auto change) {
    ExcitationOptions options = small_search();
    change(options);
    return options;
  };
  EXPECT_THROW(optimise_excitation(arm, with([](auto& o) { o.harmonics = 1; })), InvalidInput);
  EXPECT_THROW(optimise_excitation(arm, with([](auto& o) { o.frequency = 0.0; })), InvalidInput);
  EXPECT_THROW(optimise_excitation(arm, with([](auto& o) { o.rate = 1.0; })), InvalidInput);
  EXPECT_THROW(optimise_excitation(arm, with([](auto& o) { o.starts = 0; })), InvalidInput);
  EXPECT_THROW(optimise_excitation(arm, with([](auto& o) { o.limit_share = 1.5; })), InvalidInput);
  EXPECT_THROW(optimise_excitation(arm, with([](auto& o) { o.essential = 1.0; })), InvalidInput);
}

TEST(Excitation, RefusesCausesThatNoMotionSeparates) {
  const Model arm = read_model("psm-3dof");
  ExcitationOptions options = small_search();
  options.criterion = ExcitationCriterion::kDiscriminate;
  const auto refuses = [&](const char* a, const char* b) {
    options.between = {parse_cause(arm, a), parse_cause(arm, b)};
    EXPECT_THROW(optimise_excitation(arm, options), InvalidInput) << a << " " << b;
  };
  EXPECT_THROW(optimise_excitation(arm, options), InvalidInput);  // no rivals
  refuses("viscous_friction:1", "rotor_inertia:3");  // in the model already
  refuses("joint_spring:2", "joint_spring:pitch");   // the same
  refuses("torque_gain:2", "joint_spring:2");        // no values
  refuses("coupling_error:delta", "joint_spring:2");  // no motion is planned for a constant
}

}  // namespace
}  // namespace veridyn
