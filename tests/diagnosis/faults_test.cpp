#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>

#include "diagnosis/two_joint_arm.hpp"
#include "veridyn/diagnosis/friction_study.hpp"
#include "veridyn/files/model_file.hpp"

// Faults of recordings and of the robot file, and their names.

namespace veridyn {
namespace {

const QualityFinding* quality(const Diagnosis& d, QualityKind kind) {
  for (const RecordingQuality& q : d.data_quality) {
    for (const QualityFinding& f : q.findings) {
      if (f.kind == kind) return &f;
    }
  }
  return nullptr;
}

TEST_F(TwoJointArm, ATorqueWithTheWrongSignIsAFault) {
  double deviations = 0.0;
  for (const double sign : {1.0, -1.0, -100.0}) {
    DiagnosisState x = investigation(read_model("planar-2r"), {});
    for (const auto* list : {&x.train, &x.test}) {
      for (const std::string& path : *list) {
        Recording r = read_recording(path);
        r.tau *= std::abs(sign);  // in N cm the friction is the same number of standard deviations below zero
        if (sign < 0.0) r.tau.col(1) *= -1.0;
        write_recording(r, path);
      }
    }
    check_quality(x);
    ASSERT_TRUE(fit_baseline(x));
    check_torque_signs(x);
    const QualityFinding* found = quality(x.d, QualityKind::kTorqueSign);
    ASSERT_EQ(found != nullptr, sign < 0.0);
    if (found == nullptr) continue;
    EXPECT_EQ(found->joint, JointIndex{1});
    EXPECT_EQ(found->severity, Severity::kFault);
    if (deviations != 0.0) {
      EXPECT_NEAR(found->value, deviations, 1e-3 * std::abs(deviations));
    }
    deviations = found->value;
  }
}

// Torques without friction, as a controller computes them, of which a delay makes a hundredth of negative friction.
TEST_F(TwoJointArm, ALittleNegativeFrictionIsNoWrongSign) {
  truth_ = without_effects(truth_);
  for (const double share : {0.01, 0.3}) {
    DiagnosisState x = investigation(read_model("planar-2r"), {});
    for (const auto* list : {&x.train, &x.test}) {
      for (const std::string& path : *list) {
        Recording r = read_recording(path);
        r.tau.col(1) -= share * r.tau.col(1).norm() / r.dq.col(1).norm() * r.dq.col(1);
        write_recording(r, path);
      }
    }
    x.d.baseline = {};
    check_quality(x);
    ASSERT_TRUE(fit_baseline(x));
    check_torque_signs(x);
    EXPECT_EQ(quality(x.d, QualityKind::kTorqueSign) != nullptr, share > 0.1) << share;
  }
}

// Contradictions between signals and robot file come first in the verdict, and the diagnosis goes on without them: the
// recordings that are right stay.
TEST_F(TwoJointArm, ExchangedTorquesAreNamedFirstAndExchangedBack) {
  enum class Exchanged { kNone, kTraining, kAll };
  for (const Exchanged which : {Exchanged::kNone, Exchanged::kTraining, Exchanged::kAll}) {
    const bool exchanged = which != Exchanged::kNone;
    DiagnosisState x = investigation(truth_, {});
    const Diagnosis clean = diagnose(truth_, x.train, x.test, x.options);
    std::vector<std::string> some;
    if (exchanged) some = x.train;
    if (which == Exchanged::kAll) some.insert(some.end(), x.test.begin(), x.test.end());
    for (const std::string& name : some) {
      Recording r = read_recording(name);
      r.tau.col(0).swap(r.tau.col(1));
      write_recording(r, name);
    }
    const Diagnosis d = diagnose(truth_, x.train, x.test, x.options);
    EXPECT_EQ(quality(d, QualityKind::kSwappedJoints) != nullptr, exchanged);
    EXPECT_EQ(d.verdict().rfind("The torques of joint 1 (shoulder) and joint 2 (elbow) are swapped", 0) == 0, exchanged) << d.verdict();
    EXPECT_EQ(d.verdict().find("With that: ") != std::string::npos, exchanged) << d.verdict();
    EXPECT_EQ(d.mended, exchanged);
    ASSERT_EQ(d.joints.size(), 2U);
    EXPECT_EQ(d.findings.size(), clean.findings.size());
    EXPECT_LT((d.baseline.test_error.relative - clean.baseline.test_error.relative).norm(), 1e-9);
  }
}

// The curve is that of the recordings that the diagnosis used.
TEST_F(TwoJointArm, FrictionOfExchangedTorquesIsThatOfTheMendedRecordings) {
  DiagnosisState x = investigation(truth_, {});
  x.options.effects = {"stribeck_friction"};
  const FrictionStudy clean = study_friction(truth_, x.train, x.test, x.options);
  EXPECT_EQ(clean.report().find("planar-2r: friction of 2 joints"), 0U) << clean.report();
  Words all = x.train + x.test;
  for (const std::string& name : all) {
    Recording r = read_recording(name);
    r.tau.col(0).swap(r.tau.col(1));
    write_recording(r, name);
  }
  const FrictionStudy found = study_friction(truth_, x.train, x.test, x.options);
  EXPECT_EQ(found.report().find("The torques of joint 1 (shoulder) and joint 2 (elbow) are swapped"), 0U) << found.report();
  EXPECT_NE(found.report().find("With that: "), std::string::npos) << found.report();
  ASSERT_EQ(found.joints.size(), 2U);
  ASSERT_EQ(clean.joints.size(), 2U);
  for (size_t i = 0; i < 2; ++i) {
    const VectorXd& curve = clean.joints[i].curve.torque;
    ASSERT_EQ(found.joints[i].curve.torque.size(), curve.size());
    EXPECT_LT((found.joints[i].curve.torque - curve).norm(), 1e-3 * curve.norm()) << i;
  }
}

// For a planar arm the zero of the first encoder has the same torques: only gravity is tested here.
TEST_F(TwoJointArm, AnotherDirectionOfGravityIsNamedAsGravity) {
  DiagnosisState x = investigation(truth_, {});
  x.options.effects = {"gravity_tilt"};
  ModelDescription turned = truth_.description();
  turned.gravity = -turned.gravity;
  turned.values = RobotValues::kFacts;
  const Diagnosis d = diagnose(Model(std::move(turned)), x.train, x.test, x.options);
  ASSERT_FALSE(d.findings.empty());
  const Finding& f = d.findings.front();
  EXPECT_EQ(effect_of(f.cause), "gravity_tilt");
  EXPECT_NE(f.phrase.find("gravity along (0, -9.81, 0) m/s^2"), std::string::npos) << f.phrase;
}

// Without physical consistency another direction of gravity fits as well as the wrong length of the file; with it, it does not.
TEST_F(TwoJointArm, ACauseWithoutAPhysicallyConsistentArmIsNoFinding) {
  ModelFileOptions longer;
  longer.constants["l1"] = 0.6;
  const Model file = read_model("planar-2r", longer);
  DiagnosisState x = investigation(file, {});
  x.options.values = RobotValues::kPrior;
  const Diagnosis d = diagnose(file, x.train, x.test, x.options);
  EXPECT_LE(d.extended.train_error.relative.norm(), d.baseline.train_error.relative.norm()) << d.report();
  for (const Finding& f : d.findings) EXPECT_NE(effect_of(f.cause), "gravity_tilt") << d.report();
  for (const JointVerdict& v : d.joints) EXPECT_TRUE(v.state != JointState::kNamed || !d.findings.empty()) << d.report();
}

TEST_F(TwoJointArm, AnEncodersZeroIsReportedBeforeTheEquivalentAngleOfTheFile) {
  const DiagnosisState x = investigation(read_model("planar-2r"), {"encoder_offset:shoulder:offset=0.1"});
  const Diagnosis d = diagnose(read_model("planar-2r"), x.train, x.test, x.options);
  ASSERT_EQ(d.findings.size(), 1U) << d.report();
  const Finding& f = d.findings[0];
  EXPECT_EQ(to_text(x.arm, f.cause), "encoder_offset:shoulder");
  EXPECT_NEAR(f.parameters[0].value, 0.1, 0.003);
  EXPECT_LT(f.parameters[0].low, 0.1);
  EXPECT_GT(f.parameters[0].high, 0.1);
  EXPECT_LT(f.p_value, 1e-3);
  ASSERT_FALSE(f.rivals.empty());
  EXPECT_TRUE(std::holds_alternative<KinematicError>(f.rivals[0].cause));
  EXPECT_NEAR(d.extended.model->coordinates()[0].recorded.position_offset, 0.1, 0.003);
}

// The held-out recording comes from a broken sensor. Against a MODEL causes are selected on the training recordings alone; of a
// robot file a cause that the held-out recording contradicts is no finding.
TEST_F(TwoJointArm, ContradictingTestRecordingsRejectCausesButNotChangesSinceAnIdentifiedModel) {
  const std::vector<std::string> hidden = {"presliding_hysteresis:shoulder:level=3,distance=0.04",
                                           "joint_spring:2"};
  std::vector<std::string> train;
  for (unsigned k = 1; k <= 4; ++k) train.push_back(record(k, hidden));
  const std::string sound = record(5, hidden);
  Recording turned = read_recording(sound);
  turned.tau *= -0.5;
  const std::string broken = folder_.path("broken.csv");
  write_recording(turned, broken);
  const auto chosen = [&](const std::string& test, RobotValues values) {
    DiagnosisOptions options;
    options.values = values;
    options.effects = {"presliding_hysteresis", "joint_spring", "coulomb_friction", "position_force"};
    options.identification.threads = 1;
    const Diagnosis d = diagnose(read_model("planar-2r"), train, {test}, options);
    std::set<std::string> out;
    for (const Finding& f : d.findings) out.insert(to_text(truth_, f.cause) + " " + name_of(f.status));
    return std::make_pair(out, to_yaml(*d.extended.model));
  };
  const auto [causes, model] = chosen(sound, RobotValues::kFacts);
  const auto [causes_again, model_again] = chosen(broken, RobotValues::kFacts);
  EXPECT_GE(causes.size(), 2U);
  EXPECT_EQ(causes, causes_again);
  EXPECT_EQ(model, model_again);
  const std::string memory = "presliding_hysteresis:shoulder confirmed";
  EXPECT_EQ(chosen(sound, RobotValues::kPrior).first.count(memory), 1U);
  EXPECT_EQ(chosen(broken, RobotValues::kPrior).first.count(memory), 0U);
}

}  // namespace
}  // namespace veridyn
