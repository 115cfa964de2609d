#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "diagnosis/findings/finding_words.hpp"
#include "diagnosis/findings/held_out.hpp"
#include "diagnosis/two_joint_arm.hpp"

// Joints without torque, and diagnoses without held-out errors.

namespace veridyn {
namespace {

constexpr double kNoShare = std::numeric_limits<double>::infinity();

TEST(WithoutTorque, AJointDoesNotCountInSumsOverJoints) {
  const Eigen::Vector2d before(0.2, kNoShare), after(0.1, kNoShare);
  Identification baseline;
  baseline.test_error.relative = before;
  EXPECT_NEAR(explained_share(before, after, baseline), 0.75, 1e-12);
  Finding f;
  f.cause = NewEffect{"joint_spring", {0}};
  f.joint = JointIndex{0};
  f.test_before = before;
  f.test_after = after;
  EXPECT_EQ(f.held_out(), Agreement::kAgrees);
  std::swap(f.test_before, f.test_after);
  EXPECT_EQ(f.held_out(), Agreement::kContradicts);
}

class NotHeldOut : public TwoJointArm {
 protected:
  Diagnosis of_a_spring(bool held_out, bool elbow_has_torque = true) const {
    std::vector<std::string> files;
    for (unsigned k = 1; k <= 4; ++k) files.push_back(record(k, {"joint_spring:shoulder:stiffness=8"}));
    if (!elbow_has_torque) {
      Recording r = read_recording(files.back());
      r.tau.col(1).setZero();
      write_recording(r, files.back());
    }
    DiagnosisOptions options;
    options.identification.threads = 1;
    options.effects = {"joint_spring"};
    const std::vector<std::string> train(files.begin(), files.begin() + 3);
    const std::vector<std::string> test(files.begin() + 3, held_out ? files.end() : files.begin() + 3);
    return diagnose(read_model("planar-2r"), train, test, options);
  }
};

// The elbow's torque is missing in the held-out recording.
TEST_F(NotHeldOut, AFindingIsValidatedOnTheJointsWithTorque) {
  const Diagnosis d = of_a_spring(true, false);
  ASSERT_EQ(d.findings.size(), 1U) << d.report();
  EXPECT_EQ(d.findings[0].held_out(), Agreement::kAgrees) << d.report();
  EXPECT_GT(d.findings[0].explains, 0.9) << d.report();
  EXPECT_GT(d.summary.explained_by_all, 0.9);
  EXPECT_EQ(d.joints.at(0).state, JointState::kNamed) << d.report();
  EXPECT_EQ(d.joints.at(1).state, JointState::kCannotTell) << d.report();
}

// The training recordings confirm the spring; there is no held-out error.
TEST_F(NotHeldOut, WithoutHeldOutRecordingsNoJointIsAtItsFloor) {
  const Diagnosis d = of_a_spring(false);
  ASSERT_EQ(d.findings.size(), 1U) << d.report();
  EXPECT_EQ(d.findings[0].status, FindingStatus::kConfirmed);
  EXPECT_EQ(d.findings[0].held_out(), Agreement::kNotMeasured);
  ASSERT_EQ(d.joints.size(), 2U);
  for (const JointVerdict& v : d.joints) {
    EXPECT_EQ(v.state, JointState::kCannotTell);
    EXPECT_NE(v.why.find("no recording is held out"), std::string::npos) << v.why;
  }
  EXPECT_EQ(d.report().find("nan"), std::string::npos) << d.report();
}

TEST_F(NotHeldOut, TheVerdictListsJointsWithoutErrorApartFromThoseAboveTheirFloor) {
  Diagnosis d;
  d.baseline.model = truth_;
  d.hypotheses = 1;
  d.joints = {not_judged({0}, kNoShare, d.baseline)};
  EXPECT_EQ(d.verdict(), "no cause was found; joints without a held-out error: 1");
  JointVerdict above;
  above.joint = JointIndex{1};
  above.held_out = 0.2;
  above.state = JointState::kCannotTell;
  d.joints.push_back(above);
  EXPECT_EQ(d.verdict(), "no cause was found; joints above their floor: 2; joints without a held-out error: 1");
  d.joints = {above};
  EXPECT_EQ(d.verdict(), "no cause was found; joints above their floor: 2");
  d.joints[0].state = JointState::kAtFloor;
  EXPECT_EQ(d.verdict(), "no cause was found; joints with an error that no signal of the recordings predicts: 2 (20 %), noise or something that does not follow the motion");
  d.joints[0].held_out = 0.02;
  EXPECT_EQ(d.verdict(), "none");
}

// The elbow's torque is zero in all recordings: it was not recorded. The shoulder's cause is found all the same, nothing is named
// on the elbow, and one line says so.
class TorqueNotRecorded : public TwoJointArm {
 protected:
  // @param only  number of the recording without the joint's torque, from 1; 0: all.
  std::vector<std::string> recorded(const std::vector<std::string>& hidden, int silent, unsigned only) const {
    std::vector<std::string> files;
    for (unsigned k = 1; k <= 4; ++k) {
      files.push_back(record(k, hidden));
      if (only != 0 && k != only) continue;
      Recording r = read_recording(files.back());
      r.tau.col(silent).setZero();
      write_recording(r, files.back());
    }
    return files;
  }

  Diagnosis diagnosed(const Model& robot, const std::vector<std::string>& hidden, int silent,
                      const std::vector<std::string>& effects = {}, unsigned only = 0) const {
    std::vector<std::string> train = recorded(hidden, silent, only);
    const std::string test = train.back();
    train.pop_back();
    DiagnosisOptions options;
    options.identification.threads = 1;
    options.effects = effects;
    options.values = values_;
    return diagnose(robot, train, {test}, options);
  }

  RobotValues values_ = RobotValues::kPrior;  // facts: what changed since is asked

  static int count(const std::string& text, const std::string& words) {
    int out = 0;
    for (size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++out;
    return out;
  }
};

TEST_F(TorqueNotRecorded, TheJointHasNoFindingAndDoesNotChangeThoseOfOthers) {
  for (const RobotValues values : {RobotValues::kPrior, RobotValues::kFacts}) {
    for (const bool spring : {false, true}) {
      values_ = values;
      const Diagnosis d = diagnosed(read_model("planar-2r"), spring ? Words{"joint_spring:shoulder:stiffness=8"} : Words(), 1);
      EXPECT_EQ(d.changes, values == RobotValues::kFacts);
      ASSERT_EQ(d.joints.size(), 2U);
      ASSERT_EQ(d.findings.size(), spring ? 1U : 0U) << d.report();
      EXPECT_EQ(d.joints[0].state, spring ? JointState::kNamed : JointState::kAtFloor) << d.report();
      EXPECT_LT(d.extended.test_error.relative[0], 0.01);
      EXPECT_EQ(d.joints[1].state, JointState::kCannotTell);
      EXPECT_EQ(count(d.report(), "zero throughout the training recordings"), 1) << d.report();
      if (!spring) continue;
      EXPECT_EQ(to_text(truth_, d.findings[0].cause), "joint_spring:shoulder");
      EXPECT_NEAR(d.findings[0].parameters[0].value, 8.0, 0.2);
    }
  }
}

TEST_F(TorqueNotRecorded, InOneRecordingTheCauseIsFoundInTheOthers) {
  const Diagnosis d = diagnosed(read_model("planar-2r"), {"joint_spring:elbow:stiffness=8"}, 1, {}, 2);
  ASSERT_EQ(d.findings.size(), 1U) << d.report();
  EXPECT_EQ(to_text(truth_, d.findings[0].cause), "joint_spring:elbow");
  EXPECT_NEAR(d.findings[0].parameters[0].value, 8.0, 0.2);
  for (const JointVerdict& v : d.joints) EXPECT_TRUE(v.state == JointState::kNamed || v.state == JointState::kAtFloor) << d.report();
}

// Neither causes on the joint that the user names nor crosstalk from its torque are tested.
TEST_F(TorqueNotRecorded, NoCauseOnTheJointIsTestedEvenByName) {
  const Diagnosis d = diagnosed(read_model("planar-2r"), {}, 1, {"joint_spring:elbow", "torque_gain:elbow", "torque_crosstalk"});
  EXPECT_TRUE(d.findings.empty()) << d.report();
  EXPECT_TRUE(d.not_supported.empty());
  EXPECT_EQ(d.hypotheses, 0);
}

// The elbow's torque does not depend on the shoulder's own inertia.
TEST_F(TorqueNotRecorded, AnArmThatTheOtherJointsDoNotDetermineIsNotDiagnosed) {
  const Diagnosis d = diagnosed(read_model("planar-2r"), {"joint_spring:elbow:stiffness=8"}, 0);
  EXPECT_TRUE(d.findings.empty()) << d.report();
  EXPECT_FALSE(d.baseline.model.has_value());
  EXPECT_NE(d.baseline.reason.find("the torque of shoulder is zero throughout, and the other joints alone do not determine the arm"), std::string::npos) << d.baseline.reason;
}

}  // namespace
}  // namespace veridyn
