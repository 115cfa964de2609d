#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calibration/closed_forms.hpp"
#include "simulated_capture.hpp"
#include "veridyn/calibration/hand_eye.hpp"
#include "veridyn/calibration/remote_center.hpp"

namespace veridyn {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Poses = std::vector<Isometry3d>;

double angle_between(const Isometry3d& A, const Isometry3d& B) {
  return internal::rotation_vector(A.linear().transpose() * B.linear()).norm();
}

const Vector3d kCentre(0.1, -0.5, 0.02);
const Vector3d kTip(0.05, 0.02, -0.42);

// A body that turns about kCentre by sweeps about two axes, the second `across` times as wide.
PoseCapture pivoting(int frames, double across, double metres, double radians, unsigned seed) {
  RandomNumbers random(seed);
  Poses out;
  for (int k = 0; k < frames; ++k) {
    const double phase = 2.0 * M_PI * k / frames;
    Isometry3d T = Isometry3d::Identity();
    T.linear() = (Eigen::AngleAxisd(1.0 * std::sin(3.0 * phase), Vector3d::UnitZ()) *
                  Eigen::AngleAxisd(across * std::sin(5.0 * phase + 1.0), Vector3d::UnitY()))
                     .toRotationMatrix();
    T.translation() = kCentre - T.linear() * kTip;
    out.push_back(with_noise(T, metres, radians, random));
  }
  return capture_of(out);
}

TEST(RemoteCenter, ExactPosesGiveTheExactCentre) {
  const RemoteCenter found = calibrate_remote_center(pivoting(60, 0.5, 0.0, 0.0, 1));
  ASSERT_EQ(found.status, CalibrationStatus::kDone);
  EXPECT_LT((found.rcm - kCentre).norm(), 1e-12);
  EXPECT_LT((found.tip - kTip).norm(), 1e-12);
  EXPECT_LT(found.rms.norm(), 1e-12);
}

// Bodies with three markers of 0.1 mm turn by about 1 mrad of noise: 0.4 mm at the length of the tip.
TEST(RemoteCenter, IntervalsCoverTheCentreAsOftenAsStatedUnderNoiseAndOutliers) {
  constexpr int kSeeds = 60;
  int inside = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    PoseCapture poses = pivoting(600, 0.6, 1e-4, 1e-3, seed);
    for (size_t k = 7; k < poses.poses.size(); k += 50)
      poses.poses[k].translation() += Vector3d(0.02, -0.01, 0.03);
    const RemoteCenter found = calibrate_remote_center(poses);
    ASSERT_EQ(found.status, CalibrationStatus::kDone);
    EXPECT_LT(found.rcm_radius, 1.2e-4) << seed;
    EXPECT_LT((found.rcm - kCentre).norm(), 2.0 * found.rcm_radius) << seed;
    EXPECT_EQ(found.outliers, 12) << seed;
    for (int c = 0; c < 3; ++c)
      inside += std::abs(found.rcm[c] - kCentre[c]) <= found.rcm_half_width[c];
  }
  EXPECT_GE(inside, 0.90 * 3 * kSeeds);
  EXPECT_LE(inside, 0.995 * 3 * kSeeds);
}

TEST(RemoteCenter, ASweepAboutOneAxisIsRefusedWithItsReason) {
  const RemoteCenter found = calibrate_remote_center(pivoting(300, 0.0, 1e-4, 1e-3, 2));
  EXPECT_EQ(found.status, CalibrationStatus::kCannotAnswer);
  EXPECT_NE(found.reason.find("one axis only"), std::string::npos) << found.reason;
  const RemoteCenter few = calibrate_remote_center(pivoting(5, 0.5, 0.0, 0.0, 2));
  EXPECT_NE(few.reason.find("too few frames"), std::string::npos) << few.reason;
  PoseCapture still = capture_of(Poses(50, Isometry3d::Identity()));
  EXPECT_NE(calibrate_remote_center(still).reason.find("hardly turns"), std::string::npos);
}

// A shaft that slides through its sleeve has no point that stays; nor has a body that flies about.
TEST(RemoteCenter, ASlidingBodyHasNoRemoteCentre) {
  PoseCapture slides = pivoting(400, 0.5, 1e-4, 1e-3, 3);
  for (size_t k = 0; k < slides.poses.size(); ++k)
    slides.poses[k].translation() += 0.1 * std::sin(0.03 * static_cast<double>(k)) * slides.poses[k].linear().col(2);
  PoseCapture flies = slides;
  RandomNumbers random(3);
  for (Isometry3d& T : flies.poses) T.translation() = random_pose(random, 1.0).translation();
  for (const PoseCapture& poses : {slides, flies}) {
    const RemoteCenter found = calibrate_remote_center(poses);
    EXPECT_EQ(found.status, CalibrationStatus::kCannotAnswer) << found.report();
    EXPECT_NE(found.reason.find("no point stays where it is"), std::string::npos) << found.reason;
  }
}

// A body whose origin is the centre hardly moves, and its centre is known all the same.
TEST(RemoteCenter, IsFoundIfItIsTheOriginOfTheBody) {
  RandomNumbers random(4);
  Poses poses;
  for (int k = 0; k < 200; ++k) {
    Isometry3d T = random_pose(random, 0.0);
    T.translation() = kCentre;
    poses.push_back(with_noise(T, 2e-4, 2e-4, random));
  }
  const RemoteCenter found = calibrate_remote_center(capture_of(poses));
  ASSERT_EQ(found.status, CalibrationStatus::kDone) << found.reason;
  EXPECT_LT((found.rcm - kCentre).norm(), 1e-4);
}

// Files whose rows do not belong together, and a form that is not theirs.
TEST(HandEye, InconsistentPosePairsAreRefused) {
  RandomNumbers random(5);
  Poses A;
  Poses B;
  const Isometry3d T = random_pose(random, 0.4);
  for (int k = 0; k < 40; ++k) {
    A.push_back(random_pose(random, 0.3));
    B.push_back(with_noise(T.inverse() * A.back(), 1e-4, 2e-4, random));
  }
  ASSERT_EQ(calibrate_hand_eye(capture_of(A), capture_of(B)).status, CalibrationStatus::kDone);
  HandEyeOptions wrong;
  wrong.form = HandEyeForm::kEyeInHand;
  Poses shuffled = B;
  std::reverse(shuffled.begin(), shuffled.end());
  for (const HandEye& found : {calibrate_hand_eye(capture_of(A), capture_of(shuffled)),
                               calibrate_hand_eye(capture_of(A), capture_of(B), wrong)}) {
    EXPECT_EQ(found.status, CalibrationStatus::kCannotAnswer) << found.report();
    EXPECT_NE(found.reason.find("contradict"), std::string::npos) << found.reason;
  }
}

class HandEyeForms : public testing::TestWithParam<HandEyeForm> {};

// The form is found from the poses, and so is its transform.
TEST_P(HandEyeForms, FormAndTransformAreFoundFromThirtyPoses) {
  RandomNumbers random(11);
  const Isometry3d T = random_pose(random, 0.4);
  const Isometry3d other = random_pose(random, 0.1);
  Poses A;
  Poses B;
  for (int k = 0; k < 30; ++k) {
    A.push_back(random_pose(random, 0.3));
    Isometry3d b = T.inverse() * A.back();
    switch (GetParam()) {
      case HandEyeForm::kCommonPoses: break;
      case HandEyeForm::kCommonPoints: b.linear() = random_pose(random, 0.0).linear(); break;
      case HandEyeForm::kHandEye: b = T.inverse() * A.back() * T; break;
      case HandEyeForm::kEyeInHand: b = T.inverse() * A.back().inverse() * other; break;
      case HandEyeForm::kTwoBases: b = T.inverse() * A.back() * other; break;
    }
    B.push_back(with_noise(b, 1e-4, 2e-4, random));
    A.back() = with_noise(A.back(), 1e-4, 2e-4, random);
  }
  const HandEye found = calibrate_hand_eye(capture_of(A), capture_of(B));
  ASSERT_EQ(found.status, CalibrationStatus::kDone) << found.reason;
  EXPECT_EQ(found.form, GetParam()) << found.report();
  EXPECT_LT((found.transform.translation() - T.translation()).norm(), 2e-4);
  EXPECT_LT(angle_between(found.transform, T), 0.04 * M_PI / 180.0);
}

INSTANTIATE_TEST_SUITE_P(All, HandEyeForms,
                         testing::Values(HandEyeForm::kCommonPoses, HandEyeForm::kCommonPoints,
                                         HandEyeForm::kHandEye, HandEyeForm::kEyeInHand,
                                         HandEyeForm::kTwoBases),
                         [](const auto& one) {
                           std::string name = name_of(one.param);
                           for (char& c : name) c = c == '-' ? '_' : c;
                           return name;
                         });

// Two arms that hold one object, seen with the noise of three markers.
TEST(HandEye, IntervalsCoverTheTruthOverSeeds) {
  constexpr int kSeeds = 40;
  int inside = 0;
  double worst = 0.0;
  double worst_angle = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    RandomNumbers random(seed, 9);
    const Isometry3d T = random_pose(random, 0.4);
    const Isometry3d tool = random_pose(random, 0.05);
    Poses A;
    Poses B;
    for (int k = 0; k < 30; ++k) {
      const Isometry3d a = random_pose(random, 0.15);
      A.push_back(with_noise(a, 1e-4, 3e-4, random));
      B.push_back(with_noise(T.inverse() * a * tool, 1e-4, 3e-4, random));
    }
    HandEyeOptions options;
    options.form = HandEyeForm::kTwoBases;
    const HandEye found = calibrate_hand_eye(capture_of(A), capture_of(B), options);
    ASSERT_EQ(found.status, CalibrationStatus::kDone);
    const double miss = (found.transform.translation() - T.translation()).norm();
    const double turn = angle_between(found.transform, T);
    worst = std::max(worst, miss);
    worst_angle = std::max(worst_angle, turn);
    inside += miss <= found.radius;
    inside += turn <= found.radius_angle;
  }
  EXPECT_LT(worst, 2e-4);
  EXPECT_LT(worst_angle, 0.02 * M_PI / 180.0);
  EXPECT_GE(inside, 0.88 * 2 * kSeeds);
}

TEST(HandEye, UndeterminedTransformsAreRefused) {
  RandomNumbers random(4);
  Poses A;
  Poses B;
  const Isometry3d X = random_pose(random, 0.1);
  const Isometry3d Y = random_pose(random, 0.4);
  for (int k = 0; k < 30; ++k) {
    Isometry3d a = Isometry3d(Eigen::AngleAxisd(0.1 * k, Vector3d::UnitX()));
    a.translation() = 0.2 * Vector3d(random.normal(), random.normal(), random.normal());
    A.push_back(a);
    B.push_back(Y.inverse() * a * X);
  }
  const HandEye found = calibrate_hand_eye(capture_of(A), capture_of(B));
  EXPECT_EQ(found.status, CalibrationStatus::kCannotAnswer);
  EXPECT_NE(found.reason.find("one axis only"), std::string::npos) << found.reason;
  A.resize(2);
  B.resize(2);
  EXPECT_NE(calibrate_hand_eye(capture_of(A), capture_of(B)).reason.find("too few"),
            std::string::npos);
}

// Closed forms against each other: Shah's X and Y of conjugate motions are Park's X.
TEST(ClosedForms, ShahAndParkAgreeOnConjugateMotions) {
  RandomNumbers random(5);
  const Isometry3d X = random_pose(random, 0.2);
  Poses A;
  Poses B;
  for (int k = 0; k < 12; ++k) {
    A.push_back(random_pose(random, 0.3));
    B.push_back(X.inverse() * A.back() * X);
  }
  const internal::HandAndWorld both = internal::hand_and_world(A, B);
  const Isometry3d park = internal::solve_hand_eye(A, B);
  EXPECT_TRUE(both.X.isApprox(X, 1e-9));
  EXPECT_TRUE(both.Y.isApprox(X, 1e-9));
  EXPECT_TRUE(park.isApprox(X, 1e-9));
}

}  // namespace
}  // namespace veridyn
