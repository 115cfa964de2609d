#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "diagnosis/two_joint_arm.hpp"
#include "effects/plain_friction.hpp"
#include "identification/velocity_choice.hpp"
#include "recordings/files/byte_stream.hpp"
#include "recordings/kept_recordings.hpp"
#include "veridyn/identification/robot_check.hpp"
#include "veridyn/math/require.hpp"

// A diagnosis of a simulated arm of two joints whose truth is known, and how often its recordings are read.

namespace veridyn {
namespace {

Model with_gravity(const Model& arm, const Eigen::Vector3d& gravity) {
  ModelDescription d = arm.description();
  d.gravity = gravity;
  return Model(std::move(d));
}

TEST_F(TwoJointArm, OnlyEffectsOfTheOptionsAreTested) {
  DiagnosisState x{truth_, {}, {}, {}, {}};
  EXPECT_TRUE(x.tests_effect("backlash"));
  x.options.effects = {"joint_spring"};
  EXPECT_TRUE(x.tests_effect("joint_spring"));
  EXPECT_FALSE(x.tests_effect("backlash"));
}

// Some parameters are undetermined on an upright arm and act on a leaning one.
TEST_F(TwoJointArm, ParametersThatActOnlyUnderALeanAreNoLoad) {
  const Model leaning = with_gravity(truth_, {0.25, -0.15, -9.8});
  truth_ = with_gravity(truth_, {0.0, 0.0, -9.81});
  std::vector<std::string> upright, train;
  for (unsigned k = 1; k <= 4; ++k) upright.push_back(record(k, {}));
  ModelDescription d = truth_.description();
  d.values = RobotValues::kPrior;
  const Identification fit = identify(Model(std::move(d)), upright);
  ASSERT_TRUE(fit.model.has_value()) << fit.reason;
  truth_ = leaning;
  for (unsigned k = 5; k <= 8; ++k) train.push_back(record(k, {}));
  const std::string test = record(9, {});
  DiagnosisOptions options;
  options.effects = {"gravity_tilt", "payload"};
  options.identification.threads = 1;
  const Diagnosis found = diagnose(*fit.model, train, {test}, options);
  ASSERT_EQ(found.findings.size(), 1U) << found.report();
  EXPECT_EQ(effect_of(found.findings[0].cause), "gravity_tilt");
  EXPECT_LT(found.extended.test_error.relative.maxCoeff(), 0.02);
}

// Two springs are hidden, and the option names one of them.
TEST_F(TwoJointArm, ACauseWithAPlaceIsTestedThereOnly) {
  const std::vector<std::string> hidden = {"joint_spring:1", "joint_spring:2"};
  std::vector<std::string> train;
  for (unsigned k = 1; k <= 4; ++k) train.push_back(record(k, hidden));
  const std::string test = record(5, hidden);
  const auto found = [&](const std::string& asked) {
    DiagnosisOptions options;
    options.effects = {asked};
    options.identification.threads = 1;
    const Diagnosis d = diagnose(read_model("planar-2r"), train, {test}, options);
    std::vector<std::string> names;
    for (const Finding& f : d.findings) names.push_back(to_text(truth_, f.cause));
    for (const NotSupported& n : d.not_supported) names.push_back("not " + to_text(truth_, n.cause));
    std::sort(names.begin(), names.end());
    return names;
  };
  EXPECT_EQ(found("joint_spring"), (Words{"joint_spring:elbow", "joint_spring:shoulder"}));
  EXPECT_EQ(found("joint_spring:2"), Words{"joint_spring:elbow"});
  EXPECT_EQ(found("joint_spring:elbow"), Words{"joint_spring:elbow"});
  EXPECT_TRUE(found("external_contact:elbow").empty());
  EXPECT_THROW(found("joint_spring:wrist"), InvalidInput);
  EXPECT_THROW(found("coupling_error:elbow.zero"), InvalidInput);
  EXPECT_THROW(found("joint_sprung"), InvalidInput);
}

// The robot file has no friction.
TEST_F(TwoJointArm, PlainFrictionOfAllJointsIsFoundTogether) {
  const Model bare = without_effects(read_model("planar-2r"));
  ASSERT_TRUE(has_no_friction(bare));
  DiagnosisState x = investigation(bare, {});
  const Diagnosis d = diagnose(bare, x.train, x.test, x.options);
  int friction = 0;
  for (const Finding& f : d.findings) {
    ASSERT_FALSE(f.parameters.empty());
    const FoundParameter& p = f.parameters.front();
    const std::string effect = effect_of(f.cause);
    if (effect != "viscous_friction" && effect != "coulomb_friction") continue;
    ASSERT_TRUE(f.joint.has_value());
    ++friction;
    for (const EffectTerm& term : truth_.effects()) {
      if (term.effect != effect || term.axis.coefficients[f.joint->value] == 0.0) continue;
      const double truth = term.values.at(p.name);
      EXPECT_NEAR(p.value, truth, 0.05 * std::abs(truth)) << f.phrase;
    }
    EXPECT_EQ(f.status, FindingStatus::kConfirmed) << f.phrase;
  }
  EXPECT_EQ(friction, 4);
  EXPECT_LT(d.extended.test_error.relative.norm(), 0.5 * d.baseline.test_error.relative.norm());
}

TEST_F(TwoJointArm, PlainFrictionIsAddedOnlyToJointsWithoutFriction) {
  ModelDescription d = read_model("planar-2r").description();
  d.effects.resize(2);  // the shoulder's
  const Model file(std::move(d));
  DiagnosisState x = investigation(file, {});
  std::set<std::string> found;
  for (const Finding& f : diagnose(file, x.train, x.test, x.options).findings) {
    EXPECT_EQ(f.joint, JointIndex{1}) << f.phrase;
    found.insert(effect_of(f.cause));
  }
  EXPECT_EQ(found.count("viscous_friction") + found.count("coulomb_friction"), 2U);
}

// 40 ms on both joints are one cause.
TEST_F(TwoJointArm, ALargeDelayOfTheWholeArmIsCorrected) {
  DiagnosisState x = investigation(read_model("planar-2r"), {"time_delay:arm:seconds=0.04"});
  x.options.effects = {"time_delay"};
  const Diagnosis d = diagnose(read_model("planar-2r"), x.train, x.test, x.options);
  ASSERT_EQ(d.findings.size(), 1U) << d.report();
  EXPECT_FALSE(d.findings[0].joint.has_value()) << d.report();
  EXPECT_NEAR(d.findings[0].parameters[0].value, 0.04, 0.001);
  for (const Coordinate& c : d.extended.model->coordinates()) EXPECT_NEAR(c.recorded.torque_delay, 0.04, 0.001);
}

// The recorded velocity is the encoder's difference over one row; its sign is noisy at reversals.
TEST_F(TwoJointArm, ANoisyVelocityIsReplacedByTheDerivativeOfThePosition) {
  for (const double noise : {1e-5, 0.3}) {
    DiagnosisState x{read_model("planar-2r"), {}, {}, {}, {}};
    for (unsigned k = 1; k <= 2; ++k) x.train.push_back(record(k, {}, noise));
    x.options.identification.threads = 1;
    check_quality(x);
    ASSERT_TRUE(fit_baseline(x));
    const size_t expected = noise > 0.1 ? 2 : 0;
    EXPECT_EQ(x.options.identification.preprocessing.derive_velocity_of.size(), expected) << noise;
    EXPECT_EQ(x.remarks.size(), expected) << noise;
    EXPECT_LT(x.start.train_error.relative.maxCoeff(), 0.02) << noise;
  }
}

TEST_F(TwoJointArm, EveryRecordingIsOpenedAndParsedOnce) {
  std::vector<std::string> train;
  for (unsigned k = 1; k <= 2; ++k) train.push_back(record(k, {"quadratic_drag:elbow"}));
  const std::string test = record(3, {"quadratic_drag:elbow"});
  DiagnosisOptions options;
  options.effects = {"quadratic_drag", "presliding_hysteresis"};
  options.identification.threads = 2;
  const long before = files_parsed();
  const long opened = files_opened();
  const Diagnosis d = diagnose(read_model("planar-2r"), train, {test}, options);
  EXPECT_TRUE(d.baseline.model.has_value());
  EXPECT_EQ(files_parsed() - before, 3);
  EXPECT_EQ(files_opened() - opened, 3);
}

TEST_F(TwoJointArm, ProgressCountsTheHypothesesAndNeverDecreases) {
  DiagnosisOptions options;
  options.effects = {"quadratic_drag", "joint_spring"};
  std::vector<double> shares;
  std::set<std::string> told;
  options.identification.progress = [&](const std::string& what, double share) {
    told.insert(what);
    shares.push_back(share);
  };
  diagnose(read_model("planar-2r"), {record(1, {"quadratic_drag:elbow"}), record(2, {"quadratic_drag:elbow"})},
           {record(3, {"quadratic_drag:elbow"})}, options);
  EXPECT_TRUE(std::any_of(told.begin(), told.end(), [](const std::string& what) { return what.find("searching: testing hypothesis ") == 0; }));
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_EQ(shares.back(), 1.0);
}

// The settings are those of the fit, of the prediction of rows as recorded, and of check_against().
TEST_F(TwoJointArm, EveryRecordingIsPreparedOnceForEachSetting) {
  std::vector<std::string> train;
  for (unsigned k = 1; k <= 2; ++k) train.push_back(record(k, {"quadratic_drag:elbow"}));
  const std::string test = record(3, {"quadratic_drag:elbow"});
  DiagnosisOptions options;
  options.identification.threads = 2;
  long before = recordings_prepared();
  for (const std::string& one : train) check_against(read_model("planar-2r"), one, options.identification.preprocessing);
  const long questions = recordings_prepared() - before;
  before = recordings_prepared();
  const Diagnosis d = diagnose(read_model("planar-2r"), train, {test}, options);
  EXPECT_FALSE(d.findings.empty());
  EXPECT_LE(recordings_prepared() - before, 9 + questions);
}

TEST_F(TwoJointArm, AnIdentificationOpensEveryRecordingOnce) {
  const std::vector<std::string> files = {record(1, {}), record(2, {}), record(3, {})};
  const long before = files_opened();
  EXPECT_TRUE(identify(read_model("planar-2r"), {files[0], files[1]}, {files[2]}).model.has_value());
  EXPECT_EQ(files_opened() - before, 3);
}

TEST_F(TwoJointArm, RecordingsBeyondTheBoundAreStreamed) {
  const std::string path = record(1, {});
  KeptRecordings none(10);
  const long before = files_parsed();
  const auto first = open_rows(path, {}, &none).next;
  const auto second = open_rows(path, {}, &none).next;
  EXPECT_EQ(files_parsed() - before, 2);
  const Recording a = first(100);
  EXPECT_EQ(a.rows(), 100);
  EXPECT_EQ(second(100).q, a.q);
}

TEST_F(TwoJointArm, KeptRowsAreTheFilesRows) {
  const std::string path = record(1, {});
  const Recording streamed = read_recording(path);
  KeptRecordings kept;
  const auto rows = open_rows(path, {}, &kept).next;
  int total = 0;
  while (true) {
    const Recording piece = rows(97);
    if (piece.rows() == 0) break;
    EXPECT_EQ(piece.q, streamed.q.middleRows(total, piece.rows()));
    EXPECT_EQ(piece.tau, streamed.tau.middleRows(total, piece.rows()));
    total += piece.rows();
  }
  EXPECT_EQ(total, streamed.rows());
}

}  // namespace
}  // namespace veridyn
