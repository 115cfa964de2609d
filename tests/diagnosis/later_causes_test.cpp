#include "diagnosis/stages/later_causes.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/stage_support.hpp"

// Causes that are asked about only beside an error without a name: which these are, and how many there may be.

namespace veridyn {
namespace {

Finding named(Cause cause) {
  Finding f;
  f.joint = acting_joint(read_model("planar-2r"), cause);
  f.cause = std::move(cause);
  return f;
}

Finding curve(int joint, std::vector<std::string> signals) {
  Finding f = named(NewEffect{UnnamedShape::kName, {joint}});
  f.shape = UnnamedShape();
  f.shape->signals = std::move(signals);
  return f;
}

TEST(LaterCauses, AreThoseThatNobodyAsksAboutByDefault) {
  const Model arm = read_model("planar-2r");
  EXPECT_TRUE(is_later(named(NewEffect{"end_stop", {0}}), arm));
  EXPECT_TRUE(is_later(named(ChannelError{"torque_crosstalk", JointIndex{0}}), arm));
  EXPECT_FALSE(is_later(named(NewEffect{"joint_spring", {0}}), arm));
  EXPECT_FALSE(is_later(named(AddedLoad{{1}}), arm));
  EXPECT_FALSE(is_later(named(KinematicError{JointZero{{0}}}), arm));
  EXPECT_FALSE(is_later(curve(0, {"q1"}), arm));
}

TEST(LaterCauses, ForcesOfPositionAndErrorsOfTheWholeArmImitateOneAnother) {
  for (const char* effect : {"joint_spring", "position_force", "cable_coupling", "end_stop"})
    EXPECT_TRUE(acts_through_positions(named(NewEffect{effect, {0}}))) << effect;
  for (const char* effect : {"viscous_friction", "torque_offset", "quadratic_drag", "position_dependent_friction"})
    EXPECT_FALSE(acts_through_positions(named(NewEffect{effect, {0}}))) << effect;
  EXPECT_TRUE(acts_through_positions(named(ChannelError{"gravity_tilt", {}})));
  EXPECT_TRUE(acts_through_positions(named(ChannelError{"tip_force", {}})));
  EXPECT_FALSE(acts_through_positions(named(ChannelError{"torque_gain", JointIndex{0}})));
  EXPECT_FALSE(acts_through_positions(named(ChangedEffect{"joint_spring", {0}})));
  EXPECT_FALSE(acts_through_positions(curve(0, {"q1"})));
}

// The signals q1 and q12 are positions; tau1, dq1 and a word are none.
TEST(LaterCauses, JointsInQuestionHaveAConfirmedCurveOverAPosition) {
  Diagnosis d;
  d.findings = {curve(0, {"dq1", "q2"}), curve(1, {"dq1", "tau1", "t"}), curve(2, {"q12"}), curve(3, {"q1"}),
                named(NewEffect{"joint_spring", {1}})};
  d.findings[3].status = FindingStatus::kNotConfirmed;
  EXPECT_EQ(joints_in_question(d), (std::set<int>{0, 2}));
}

class NamesAndCurves : public Stages {
 protected:
  Diagnosis diagnosed(const std::vector<std::string>& hidden, int most) const {
    std::vector<std::string> train;
    for (unsigned k = 1; k <= 3; ++k) train.push_back(record(k, hidden));
    const std::string test = record(4, hidden);
    DiagnosisOptions options;
    options.identification.threads = 1;
    options.max_effects = most;
    return diagnose(read_model("planar-2r"), train, {test}, options);
  }

  static Words names(const Diagnosis& d) {
    Words out;
    for (const Finding& f : d.findings) {
      if (!f.shape) out.push_back(to_text(*d.baseline.model, f.cause));
    }
    std::sort(out.begin(), out.end());
    return out;
  }
};

TEST_F(NamesAndCurves, ErrorsWithCurvesAreThoseOfTheFitWhereNoCurveIsBetter) {
  DiagnosisState x = investigation(read_model("planar-2r"), {});
  x.d.extended = x.start;
  const VectorXd fit = x.fold_errors(x.d.extended).relative();
  EXPECT_EQ(errors_with_curves(x), fit);
  x.d.findings = {curve(0, {"q1"}), curve(1, {"q2"})};
  x.d.findings[0].folds_after = 0.5 * fit;
  x.d.findings[1].folds_after = 0.25 * fit;
  EXPECT_EQ(errors_with_curves(x), Eigen::Vector2d(0.5 * fit[0], 0.25 * fit[1]));
  EXPECT_EQ(errors_with_curves(x, JointIndex{1}), Eigen::Vector2d(fit[0], 0.25 * fit[1]));
  x.d.findings[1].folds_after = 2.0 * fit;
  x.d.findings[0].status = FindingStatus::kNotConfirmed;
  EXPECT_EQ(errors_with_curves(x), fit);
}

// Where no name may be given, a curve that a later cause would explain stays a curve.
TEST_F(NamesAndCurves, WithoutNamesThereIsNoLaterCauseEither) {
  const std::vector<std::string> hidden = {"end_stop:shoulder:stiffness=60,centre=0,reach=0.7,side=1"};
  const Diagnosis one = diagnosed(hidden, 1);
  EXPECT_EQ(names(one), Words{"end_stop:shoulder"}) << one.report();
  const Diagnosis none = diagnosed(hidden, 0);
  EXPECT_TRUE(names(none).empty()) << none.report();
  EXPECT_EQ(none.joints[0].state, JointState::kUnnamed) << none.report();
}

// A later cause that became part of the arm is a name as any other.
TEST_F(NamesAndCurves, ALaterCauseIsOneOfTheMostThatMayBeNamed) {
  const std::vector<std::string> hidden = {"end_stop:shoulder:stiffness=60,centre=0,reach=0.7,side=1",
                                           "quadratic_drag:elbow:coefficient=0.6"};
  EXPECT_EQ(names(diagnosed(hidden, 2)), (Words{"end_stop:shoulder", "quadratic_drag:elbow"}));
  const Diagnosis one = diagnosed(hidden, 1);
  EXPECT_EQ(names(one).size(), 1U) << one.report();
}

}  // namespace
}  // namespace veridyn
