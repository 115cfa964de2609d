#include "veridyn/calibration/links.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "calibration/links/link_chain.hpp"
#include "simulated_capture.hpp"
#include "veridyn/calibration/pose_design.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

constexpr double kDegree = M_PI / 180.0;

Model with_constant(const std::string& robot, const std::string& name, double value) {
  ModelFileOptions options;
  options.constants[name] = value;
  return read_model(robot, options);
}

const LinkConstant& constant(const LinksCalibration& r, const std::string& name,
                             const std::string& frame = "") {
  for (const LinkConstant& c : r.constants) {
    if (c.name == name && c.frame == frame) return c;
  }
  throw InvalidInput("no constant " + name + " of " + frame);
}

// The chain's poses are frame_pose(), and its derivatives are differences of them.
TEST(Links, DerivativesOfTheChainMatchCentralDifferences) {
  for (const char* robot : {"psm-wrist", "ur10e", "mtm"}) {
    const Model arm = read_model(robot);
    const FrameIndex frame{static_cast<int>(arm.frames().size()) - 1};
    RandomNumbers random(2);
    const Eigen::Isometry3d base = random_pose(random, 0.3);
    const Eigen::Isometry3d tool = random_pose(random, 0.1);
    const internal::LinkParameters parameters(arm, frame, true, true, true);
    internal::LinkChain chain(parameters, base, tool);
    VectorXd q(arm.joints());
    for (double& v : q) v = 0.3 * random.normal();
    MatrixXd J;
    const Eigen::Isometry3d T = chain.pose(q, &J);
    Eigen::Isometry3d expected;
    expected.matrix() = frame_pose(arm, q, frame).matrix();
    expected = base * expected * tool;
    EXPECT_TRUE(T.isApprox(expected, 1e-12)) << robot;
    VectorXd x = 0.01 * VectorXd::Random(parameters.size());
    chain.set(x);
    const Eigen::Isometry3d at = chain.pose(q, &J);
    for (int p = 0; p < parameters.size(); ++p) {
      VectorXd up = x;
      VectorXd down = x;
      up[p] += 1e-6;
      down[p] -= 1e-6;
      chain.set(up);
      const Eigen::Isometry3d high = chain.pose(q, nullptr);
      chain.set(down);
      const Eigen::Isometry3d low = chain.pose(q, nullptr);
      VectorXd difference(6);
      difference << internal::rotation_vector(high.linear() * low.linear().transpose()) / 2e-6,
          (high.translation() - low.translation()) / 2e-6;
      EXPECT_LT((difference - J.col(p)).norm(), 1e-6 * (1.0 + J.col(p).norm()))
          << robot << ": " << parameters.all()[p].name << " of "
          << parameters.all()[p].frame;
    }
    // The arm with these numbers written into it has the same poses.
    chain.set(x);
    const Model applied = parameters.arm_with(x);
    Eigen::Isometry3d written;
    VectorXd q_true = q;
    for (int i = 0; i < arm.joints(); ++i)
      q_true[i] -= applied.coordinates()[i].recorded.position_offset;
    written.matrix() = frame_pose(applied, q_true, frame).matrix();
    EXPECT_TRUE((chain.base() * written * chain.tool()).isApprox(at, 1e-9)) << robot;
  }
}

TEST(Links, AWrongBetaIsIdentifiedAsTheOnlyError) {
  const Model truth = read_model("psm-3dof");
  const double beta = truth.description().constants.at("beta");
  const Model file = with_constant("psm-3dof", "beta", beta + kDegree);
  const PoseCapture poses = captured_poses(truth, "tool", 200, 0.9, 1e-4, 1e-3, 3);
  LinksOptions options;
  options.frame = "tool";
  const LinksCalibration found = calibrate_links(file, poses, options);
  ASSERT_EQ(found.status, CalibrationStatus::kDone) << found.reason;
  ASSERT_EQ(found.named.size(), 1U) << found.report();
  EXPECT_EQ(found.constants[found.named[0]].name, "beta") << found.report();
  const LinkConstant& c = constant(found, "beta");
  EXPECT_NEAR(c.found, beta, 0.02 * kDegree);
  EXPECT_LE(c.low, beta);
  EXPECT_GE(c.high, beta);
  EXPECT_TRUE(c.identifiable);
  EXPECT_LT(found.held_out_rms, 2.5e-4);
  // The robot that is written has it, formulas and all.
  const Model again = read_yaml(to_yaml(*found.model), "found.yaml");
  EXPECT_NEAR(again.description().constants.at("beta"), c.found, 1e-12);
}

TEST(Links, AWrongRatioOfTheCounterweightIsFoundWithBaseAndToolUnknown) {
  const Model truth = with_constant("psm-3dof", "delta", 0.45);
  const Model file = read_model("psm-3dof");
  RandomNumbers random(8);
  const PoseCapture poses =
      captured_poses(truth, "counterweight", 150, 0.9, 1e-4, 1e-3, 5, random_pose(random, 0.5),
                     random_pose(random, 0.05));
  LinksOptions options;
  options.frame = "counterweight";
  const LinksCalibration found = calibrate_links(file, poses, options);
  ASSERT_EQ(found.status, CalibrationStatus::kDone) << found.reason;
  EXPECT_TRUE(found.base_free);
  ASSERT_EQ(found.named.size(), 1U) << found.report();
  EXPECT_NEAR(constant(found, "delta").found, 0.45, 0.001) << found.report();
}

TEST(Links, ALengthAndAnEncoderZeroOfASixJointArmAreFound) {
  const Model file = read_model("ur10e");
  ModelDescription d = file.description();
  Frame& forearm = d.frames[file.find_frame("forearm")->value];
  DhRow row = *forearm.dh;
  row.a += 0.003;
  forearm.variable.offset = 0.0;
  row.theta += 0.4 * kDegree;
  place(forearm, row);
  const Model truth(std::move(d));
  const PoseCapture poses = captured_poses(truth, "flange", 120, 0.4, 1e-4, 5e-4, 7);
  LinksOptions options;
  options.frame = "flange";
  const LinksCalibration found = calibrate_links(file, poses, options);
  ASSERT_EQ(found.status, CalibrationStatus::kDone) << found.reason;
  EXPECT_TRUE(found.explained) << found.report();
  EXPECT_EQ(found.named.size(), 2U) << found.report();
  EXPECT_NEAR(constant(found, "a", "forearm").found, row.a, 1e-4);
  // The poses cannot separate a zero from the constant of its row, and a zero is the likelier one. A
  // recorded position is the true one plus its zero.
  EXPECT_NEAR(constant(found, "zero of elbow").found, -0.4 * kDegree, 0.02 * kDegree);
  EXPECT_NE(constant(found, "zero of elbow").why.find("theta of forearm"), std::string::npos);
  EXPECT_FALSE(constant(found, "theta", "forearm").identifiable);
}

// The encoder zero of pitch is wrong by 20 mrad. Angles of two frames beside it explain that as well;
// where base and tool are unknown, so do other poses of the tool.
TEST(Links, AWrongEncoderZeroIsPreferredToEquallyGoodLinkAngles) {
  const Model arm = read_model("psm-3dof");
  for (const char* frame : {"tool", "wrist", "counterweight"}) {
    PoseCapture poses = captured_poses(arm, frame, 150, 0.9, 1e-4, 5e-4, 11);
    poses.q.col(1).array() += 0.02;
    for (const AttachedPose known : {AttachedPose::kAutomatic, AttachedPose::kFree}) {
      // No other body is on the instrument's frame, so its free pose absorbs the whole zero.
      if (known == AttachedPose::kFree && std::string(frame) == "wrist") continue;
      LinksOptions options;
      options.frame = frame;
      options.base = options.tool = known;
      const LinksCalibration found = calibrate_links(arm, poses, options);
      ASSERT_EQ(found.named.size(), 1U) << frame << "\n" << found.report();
      const LinkConstant& zero = found.constants[found.named[0]];
      EXPECT_EQ(zero.name, "zero of pitch") << frame << "\n" << found.report();
      EXPECT_LE(zero.low, 0.02) << found.report();
      EXPECT_GE(zero.high, 0.02) << found.report();
      EXPECT_LT(found.held_out_rms, 2.5e-4) << frame << "\n" << found.report();
      EXPECT_LT(found.tool.translation().norm(), 2e-3) << frame << "\n" << found.report();
    }
  }
}

TEST(Links, ACorrectFileIsUnchangedByPosesOrPositions) {
  const Model arm = read_model("psm-3dof");
  PoseCapture poses = captured_poses(arm, "tool", 150, 0.9, 1e-4, 1e-3, 9);
  LinksOptions options;
  options.frame = "tool";
  const LinksCalibration right = calibrate_links(arm, poses, options);
  ASSERT_EQ(right.status, CalibrationStatus::kDone) << right.reason;
  EXPECT_TRUE(right.explained && right.named.empty()) << right.report();
  poses.has_orientation = false;
  const double beta = arm.description().constants.at("beta");
  const LinksCalibration found =
      calibrate_links(with_constant("psm-3dof", "beta", beta + kDegree), poses, options);
  ASSERT_EQ(found.status, CalibrationStatus::kDone) << found.reason;
  EXPECT_NEAR(constant(found, "beta").found, beta, 0.1 * kDegree) << found.report();
}

TEST(Links, UndeterminedConstantsAreRefused) {
  const Model arm = read_model("psm-3dof");
  PoseCapture poses = captured_poses(arm, "tool", 5, 0.9, 1e-4, 1e-3, 9);
  EXPECT_NE(calibrate_links(arm, poses).reason.find("too few frames"), std::string::npos);
  poses = captured_poses(arm, "tool", 50, 0.0, 1e-4, 1e-3, 9);
  EXPECT_NE(calibrate_links(arm, poses).reason.find("no joint moves"), std::string::npos);
  poses.q.conservativeResize(Eigen::NoChange, 2);
  EXPECT_THROW(calibrate_links(arm, poses), InvalidInput);
}

// Poses of another frame, of other rows, or of joints in degrees: no constant explains them, and it is
// not motion that is missing.
TEST(Links, PosesOfAnotherFrameAreRefused) {
  const Model arm = read_model("ur10e");
  const std::string last = arm.frames().back().name;
  LinksOptions options;
  options.frame = last;
  const PoseCapture right = captured_poses(arm, last, 60, 0.9, 1e-4, 1e-3, 9);
  ASSERT_EQ(calibrate_links(arm, right, options).status, CalibrationStatus::kDone);
  PoseCapture degrees = right;
  degrees.q /= kDegree;
  PoseCapture shuffled = right;
  shuffled.q = right.q.colwise().reverse();
  const PoseCapture elsewhere = captured_poses(arm, arm.frames()[2].name, 60, 0.9, 1e-4, 1e-3, 9);
  for (const PoseCapture& poses : {degrees, shuffled, elsewhere}) {
    const LinksCalibration found = calibrate_links(arm, poses, options);
    EXPECT_EQ(found.status, CalibrationStatus::kCannotAnswer) << found.report();
    EXPECT_NE(found.reason.find("contradict"), std::string::npos) << found.reason;
  }
  EXPECT_NE(calibrate_links(arm, degrees, options).reason.find("beyond its limits"), std::string::npos);
}

// The wrong direction of the counterweight, which torques show as well.
TEST(Links, TheConstantFromPosesAgreesWithTheConstantFromTorques) {
  const Model truth = read_model("psm-3dof");
  const Model printed = read_model("psm-3dof-printed");
  const double beta = truth.description().constants.at("beta");
  const PoseCapture poses = captured_poses(truth, "counterweight", 150, 0.9, 1e-4, 1e-3, 5);
  LinksOptions options;
  options.frame = "counterweight";
  const LinksCalibration found = calibrate_links(printed, poses, options);
  ASSERT_EQ(found.named.size(), 1U) << found.report();
  EXPECT_NEAR(constant(found, "theta", "counterweight_rail").found, -0.5 * M_PI, 0.05 * kDegree)
      << found.report();
  const std::string line = compare_wrong_constant(found, "counterweight_rail", "theta",
                                                  -0.5 * M_PI - 0.005, -0.5 * M_PI - 0.02,
                                                  -0.5 * M_PI + 0.01);
  EXPECT_NE(line.find("they agree"), std::string::npos) << line;
  EXPECT_NE(compare_wrong_constant(found, "counterweight_rail", "theta", -0.5 * M_PI - beta - 0.1,
                                   -0.5 * M_PI - beta - 0.12, -0.5 * M_PI - beta - 0.08)
                .find("by another amount"),
            std::string::npos);
}

// At first the wrong constant is all noise, of 16 mm; few poses, at the ends of the ranges.
TEST(Links, TheResidualOfAWrongConstantIsNotCountedAsNoise) {
  const Model truth = read_model("psm-3dof");
  const Model printed = read_model("psm-3dof-printed");
  PoseDesignOptions design;
  design.poses = 30;
  design.frame = "counterweight";
  const PoseDesign where = design_poses(truth, design);
  PoseCapture poses = captured_poses(truth, "counterweight", 30, 0.9, 0.0, 0.0, 5);
  RandomNumbers random(7);
  const FrameIndex frame = *truth.find_frame("counterweight");
  for (int k = 0; k < 30; ++k) {
    const auto at = static_cast<std::size_t>(k);
    poses.q.row(k) = where.q.row(k);
    poses.poses[at] = frame_pose(truth, poses.q.row(k).transpose(), frame);
    for (int c = 0; c < 3; ++c) poses.poses[at].translation()[c] += 1e-4 * random.normal();
    poses.poses[at].rotate(Eigen::AngleAxisd(1e-3 * random.normal(), Eigen::Vector3d::UnitX()));
  }
  LinksOptions options;
  options.frame = "counterweight";
  const LinksCalibration found = calibrate_links(printed, poses, options);
  EXPECT_NEAR(constant(found, "theta", "counterweight_rail").found, -0.5 * M_PI, 0.1 * kDegree)
      << found.report();
  EXPECT_LT(found.held_out_rms, 3e-4) << found.report();
}

// D-optimal poses stay within the limits and determine the constants better than random ones.
TEST(PoseDesign, StaysWithinLimitsAndLowersTheVariance) {
  const Model arm = read_model("kuka-lwr4");
  PoseDesignOptions options;
  options.candidates = 200;
  options.poses = 12;
  const PoseDesign design = design_poses(arm, options);
  ASSERT_EQ(design.status, CalibrationStatus::kDone) << design.reason;
  EXPECT_GT(design.gain, 1.1);
  for (int i = 0; i < arm.joints(); ++i) {
    EXPECT_LE(design.q.col(i).maxCoeff(), arm.coordinates()[i].limits.upper);
    EXPECT_GE(design.q.col(i).minCoeff(), arm.coordinates()[i].limits.lower);
  }
  for (Eigen::Index k = 1; k < design.time.size(); ++k) EXPECT_GT(design.time[k], design.time[k - 1]);
  options.poses = 3;
  EXPECT_NE(design_poses(arm, options).reason.find("too few poses"), std::string::npos);
}

}  // namespace
}  // namespace veridyn
