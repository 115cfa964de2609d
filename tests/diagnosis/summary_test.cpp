#include <gtest/gtest.h>

#include "diagnosis/findings/finding_words.hpp"
#include "diagnosis/findings/held_out.hpp"
#include "diagnosis/findings/summary.hpp"

// The order of findings, and their errors on held-out recordings.

namespace veridyn {
namespace {

VectorXd errors(double a, double b) {
  return Eigen::Vector2d(a, b);
}

Finding finding(const std::string& effect, int joint, double explains) {
  Finding f;
  f.cause = NewEffect{effect, {joint}};
  f.joint = JointIndex{joint};
  f.explains = explains;
  return f;
}

Diagnosis diagnosis(const VectorXd& before, const VectorXd& after) {
  Diagnosis d;
  d.baseline.test_error.relative = before;
  d.extended.test_error.relative = after;
  return d;
}

TEST(Summary, FindingsThatExplainMostComeFirst) {
  Diagnosis d = diagnosis(errors(0.2, 0.2), errors(0.05, 0.05));
  d.findings = {finding("first found", 0, 0.01), finding("small", 0, 0.02),
                finding("large", 1, 0.6), finding("middling", 0, 0.3)};
  summarize(d, {});
  EXPECT_EQ(d.summary.main, 3);
  EXPECT_EQ(effect_of(d.findings[0].cause), "first found");  // it was found first, whatever it explains
  EXPECT_EQ(effect_of(d.findings[1].cause), "large");
  EXPECT_EQ(effect_of(d.findings[2].cause), "middling");
  EXPECT_FALSE(d.findings[3].main);
  EXPECT_TRUE(d.small_apart);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(d.findings[k].rank, k + 1);
  EXPECT_NEAR(d.summary.explained_by_main, 0.91, 1e-12);
  EXPECT_NEAR(d.summary.explained_by_all, 1.0 - 0.05 * 0.05 / 0.04, 1e-12);
  EXPECT_TRUE(d.summary.worse_joints.empty());
}

// The curve predicts the difference between repeats, so that the remaining error is below the noise floor.
TEST(Summary, CurvesWithoutANameCountAmongAllFindings) {
  Diagnosis d = diagnosis(errors(0.2, 0.1), errors(0.2, 0.1));
  d.baseline.noise_floor = errors(0.19, 0.1);
  d.findings = {finding(UnnamedShape::kName, 0, 0.98), finding("nothing", 1, 0.0)};
  d.findings[0].shape.emplace();
  d.findings[0].test_before = errors(0.2, 0.1);
  d.findings[0].test_after = errors(0.03, 0.1);
  summarize(d, {});
  EXPECT_NEAR(d.summary.explained_by_all, 1.0, 1e-12);
}

TEST(Summary, TheFirstFindingIsConfirmedAndNotContradicted) {
  Diagnosis d = diagnosis(errors(0.2, 0.2), errors(0.1, 0.1));
  d.findings = {finding("not confirmed", 0, 0.0), finding("contradicted", 0, 0.0),
                finding("agrees", 1, 0.01), finding("large", 0, 0.6)};
  d.findings[0].status = FindingStatus::kNotConfirmed;
  d.findings[1].test_before = d.findings[2].test_after = errors(0.1, 0.1);
  d.findings[1].test_after = d.findings[2].test_before = errors(0.2, 0.2);
  Diagnosis since_a_model = d;
  since_a_model.changes = true;
  summarize(d, {});
  EXPECT_EQ(effect_of(d.findings[0].cause), "agrees");
  EXPECT_EQ(effect_of(d.findings[1].cause), "large");
  EXPECT_EQ(d.summary.main, 2);
  summarize(since_a_model, {});
  EXPECT_EQ(effect_of(since_a_model.findings[0].cause), "agrees");
}

// A load need not be the same in all recordings, and what changed on one joint counts beside a larger change of another.
TEST(Summary, OfChangesALoadThatIsGoneAndASmallOneOfItsOwnJointAreListed) {
  Diagnosis d = diagnosis(errors(0.2, 0.9), errors(0.1, 0.1));
  d.findings = {finding("large", 1, 0.95), finding("own joint", 0, 0.02), finding("little", 1, 0.02), finding("gone", 1, 0.0)};
  for (Finding& f : d.findings) f.test_before = f.test_after = errors(0.2, 0.2);
  d.findings[0].test_after = errors(0.2, 0.1);
  d.findings[1].test_after = errors(0.1, 0.2);
  d.findings[2].test_after = errors(0.2, 0.19);
  d.findings[3].test_after = errors(0.3, 0.3);
  d.findings[3].cause = AddedLoad{FrameIndex{1}};
  Diagnosis since_a_model = d;
  since_a_model.changes = true;
  summarize(d, {});
  EXPECT_EQ(d.summary.main, 1);
  summarize(since_a_model, {});
  EXPECT_EQ(since_a_model.summary.main, 3);
  EXPECT_EQ(effect_of(since_a_model.findings.back().cause), "little");
}

// Beside a curve over the same torque a gain is a mean of a nonlinear relation.
TEST(Summary, AGainBesideACurveOverItsTorqueIsNotCalledAConstantFactor) {
  for (const char* signal : {"tau2", "tau1", "q2"}) {
    Diagnosis d = diagnosis(errors(0.2, 0.2), errors(0.1, 0.1));
    d.findings = {finding("unnamed", 1, 0.3), finding("unnamed", 1, 0.3)};
    d.findings[0].cause = ChannelError{"torque_gain", JointIndex{1}};
    d.findings[0].phrase = "a recorded torque that is 24 % too small";
    d.findings[1].shape.emplace();
    d.findings[1].shape->signals = {signal};
    summarize(d, {});
    EXPECT_EQ(d.findings[0].phrase.find("no constant proportion") != std::string::npos, signal == std::string("tau2")) << signal;
  }
}

TEST(Summary, TheVerdictNamesJointsWithALargerError) {
  Diagnosis d = diagnosis(errors(0.2, 0.1), errors(0.1, 0.15));
  d.findings = {finding("backlash", 1, -0.1)};
  d.findings[0].phrase = "a gap";
  d.findings[0].status = FindingStatus::kNotConfirmed;
  summarize(d, {});
  ASSERT_EQ(d.summary.worse_joints, (std::vector<JointIndex>{{1}}));
  EXPECT_NE(d.verdict().find("worse on joint 2"), std::string::npos) << d.verdict();
  EXPECT_NE(d.verdict().find("do not confirm"), std::string::npos) << d.verdict();
  d.findings.clear();
  EXPECT_EQ(d.verdict(), "none");
}

TEST(HeldOut, TheShareRefersToTheErrorAboveTheNoiseFloor) {
  Identification baseline;
  baseline.test_error.relative = (VectorXd(2) << 0.5, 0.1).finished();
  baseline.noise_floor = VectorXd::Constant(2, 0.1);
  const VectorXd after = (VectorXd(2) << 0.3, 0.1).finished();
  EXPECT_NEAR(explained_share(baseline.test_error.relative, after, baseline), 0.16 / 0.24, 1e-12);
  EXPECT_NEAR(explained_share(after, baseline.test_error.relative, baseline), -0.16 / 0.24, 1e-12);
  EXPECT_EQ(explained_share(after, {}, baseline), 0.0);
  baseline.noise_floor = VectorXd::Constant(2, 0.6);
  EXPECT_EQ(explained_share(baseline.test_error.relative, after, baseline), 0.0);
}

// The test recordings contradict the findings here; the status does not depend on them.
TEST(Status, IsConfirmedIfTheCrossValidatedErrorFallsInSumAndOnTheFindingsJoint) {
  Finding f = finding("backlash", 0, 0.0);
  const auto status = [&f](const VectorXd& before, const VectorXd& after) {
    f.folds_before = f.test_after = before;
    f.folds_after = f.test_before = after;
    return status_of(f);
  };
  EXPECT_EQ(status(errors(0.2, 0.2), errors(0.1, 0.2)), FindingStatus::kConfirmed);
  EXPECT_EQ(status(errors(0.2, 0.2), errors(0.21, 0.1)), FindingStatus::kNotConfirmed);
  EXPECT_EQ(status(errors(0.2, 0.2), errors(0.19, 0.4)), FindingStatus::kNotConfirmed);
  EXPECT_EQ(f.held_out(), Agreement::kContradicts);
  // A wrong zero of one encoder changes the torques of all joints, a wrong gain those of its own.
  f.cause = ChannelError{"torque_gain", JointIndex{0}};
  EXPECT_EQ(status(errors(0.2, 0.2), errors(0.21, 0.1)), FindingStatus::kNotConfirmed);
  f.cause = ChannelError{"encoder_offset", JointIndex{0}};
  EXPECT_EQ(status(errors(0.2, 0.2), errors(0.21, 0.1)), FindingStatus::kConfirmed);
  f.cause = AddedLoad{FrameIndex{1}};  // acts on every joint that carries it
  EXPECT_EQ(status(errors(0.2, 0.2), errors(0.21, 0.1)), FindingStatus::kConfirmed);
  EXPECT_EQ(status(errors(0.2, 0.2), errors(0.21, 0.2)), FindingStatus::kNotConfirmed);
  f.joint.reset();  // the whole arm: only the sum counts
  EXPECT_EQ(status(errors(0.2, 0.2), errors(0.21, 0.1)), FindingStatus::kConfirmed);
}

}  // namespace
}  // namespace veridyn
