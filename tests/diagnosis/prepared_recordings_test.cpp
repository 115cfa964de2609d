#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/two_joint_arm.hpp"

// Preparation of recordings: the choice of velocities, and intervals that are left out.

namespace veridyn {
namespace {

class OfRecordings : public TwoJointArm {
 protected:
  DiagnosisState recorded() const {
    DiagnosisState x{read_model("planar-2r"), {}, {}, {}, {}};
    for (unsigned k = 1; k <= 4; ++k) x.train.push_back(record(k, {}));
    x.test = {record(5, {})};
    x.options.identification.threads = 1;
    return x;
  }

  template <typename Change>
  static void rewrite(const std::string& path, const Change& change) {
    Recording r = read_recording(path);
    change(r);
    write_recording(r, path);
  }

  static std::vector<QualityFinding> told(const DiagnosisState& x, const std::string& path,
                                          QualityKind kind) {
    std::vector<QualityFinding> out;
    for (const RecordingQuality& q : x.d.data_quality) {
      if (q.file != path) continue;
      for (const QualityFinding& f : q.findings) {
        if (f.kind == kind) out.push_back(f);
      }
    }
    return out;
  }
};

TEST_F(OfRecordings, AVelocityOfAnotherScaleIsTakenFromThePosition) {
  DiagnosisState x = recorded();
  for (const std::string& path : x.train) rewrite(path, [](Recording& r) { r.dq.col(1) *= 0.5; });
  x.options.identification.test_preprocessing = x.options.identification.preprocessing;
  check_quality(x);
  EXPECT_EQ(x.options.identification.preprocessing.derive_velocity_of, (std::vector<JointIndex>{{1}}));
  EXPECT_EQ(x.options.identification.test_preprocessing->derive_velocity_of, (std::vector<JointIndex>{{1}}));
  const std::vector<QualityFinding> found = told(x, x.train[0], QualityKind::kVelocityScale);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NE(found[0].sentence.find("taken from its position"), std::string::npos);
  ASSERT_TRUE(fit_baseline(x));
  EXPECT_LT(x.start.train_error.relative.maxCoeff(), 0.02);
}

TEST_F(OfRecordings, QualityIsCheckedOnceForARecordingInBothLists) {
  DiagnosisState x = recorded();
  x.test = {x.train[1], x.train[3], x.test[0]};
  check_quality(x);
  ASSERT_EQ(x.d.data_quality.size(), 5U);
  EXPECT_EQ(x.d.data_quality[4].file, x.test[2]);
}

// Both velocities are noisier than the derivatives of the positions, but on the first joint the noise of the torque is larger.
TEST_F(OfRecordings, AVelocityIsReplacedOnlyIfThatLowersTheErrorOfItsJoint) {
  DiagnosisState x = recorded();
  for (const std::string& path : x.train) {
    rewrite(path, [](Recording& r) {
      std::mt19937 random(7);
      std::normal_distribution<double> gauss;
      for (Eigen::Index k = 0; k < r.dq.rows(); ++k) {
        r.dq(k, 0) += 0.003 * gauss(random);
        r.dq(k, 1) += 0.3 * gauss(random);
        r.tau(k, 0) += 30.0 * gauss(random);
      }
    });
  }
  check_quality(x);
  EXPECT_EQ(told(x, x.train[0], QualityKind::kVelocityNoise).size(), 2U);
  ASSERT_TRUE(fit_baseline(x));
  EXPECT_EQ(x.options.identification.preprocessing.derive_velocity_of, (std::vector<JointIndex>{{1}}));
  ASSERT_EQ(x.remarks.size(), 1U);
  EXPECT_NE(x.remarks[0].find("joint 2"), std::string::npos) << x.remarks[0];
}

// The push is in the held-out recording; the error outside of it is reported as well.
TEST_F(OfRecordings, APushIsAFindingAndItsTimeIsLeftOut) {
  DiagnosisState x = recorded();
  rewrite(x.test[0], [](Recording& r) {
    for (Eigen::Index k = 0; k < r.tau.rows(); ++k) {
      if (r.time[k] > 5.0 && r.time[k] < 6.0) r.tau(k, 1) += 15.0;
    }
  });
  const auto diagnosed = [&] { return diagnose(x.arm, x.train, x.test, x.options); };
  const Diagnosis d = diagnosed();
  ASSERT_EQ(d.findings.size(), 1U) << d.report();
  const Finding& f = d.findings[0];
  EXPECT_TRUE(std::holds_alternative<ExternalContact>(f.cause));
  EXPECT_EQ(f.source, x.test[0]);
  EXPECT_NEAR(f.parameters[1].value, 5.0, 0.2);
  EXPECT_NEAR(f.parameters[2].value, 6.0, 0.2);
  EXPECT_LT(f.test_outside[1], 0.5 * f.test_before[1]);
  EXPECT_EQ(d.excluded_intervals.size(), 1U);
  x.options.effects = {"joint_spring"};
  EXPECT_TRUE(diagnosed().findings.empty());  // nobody asked about it
}

}  // namespace
}  // namespace veridyn
