#include "veridyn/excitation/workspace_limits.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "support/sample_arms.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/excitation/excitation.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kFine = 7001;  // ten times as fine as any grid of the search, and no multiple of it

ExcitationOptions small_search() {
  ExcitationOptions options;
  options.starts = 1;
  options.iterations = 30;
  return options;
}

Eigen::Vector3d place(const Model& arm, const MotionSamples& m, Eigen::Index row,
                      const char* frame) {
  return frame_pose(arm, m.q.row(row).transpose(), *arm.find_frame(frame)).matrix().topRightCorner<3, 1>();
}

MotionSamples fine(const Excitation& e) {
  return e.trajectory.samples(period_instants(e.trajectory.frequency(), kFine));
}

TEST(WorkspaceLimits, ABoxHoldsBetweenSamples) {
  const Model arm = read_model("kuka-lwr4");
  ExcitationOptions options = small_search();
  options.limit_share = 1.0;
  options.workspace.boxes = {{"link7", {-0.6, -0.6, 0.2}, {0.6, kInfinity, kInfinity}}};
  const Excitation e = optimise_excitation(arm, options);
  ASSERT_EQ(e.status, ExcitationStatus::kDone);
  const MotionSamples m = fine(e);
  for (Eigen::Index k = 0; k < m.rows(); ++k) {
    const Eigen::Vector3d p = place(arm, m, k, "link7");
    EXPECT_GE(p.x(), -0.6 - 1e-9);
    EXPECT_LE(p.x(), 0.6 + 1e-9);
    EXPECT_GE(p.y(), -0.6 - 1e-9);
    EXPECT_GE(p.z(), 0.2 - 1e-9);
  }
  // Without the box the motion leaves it: the test could fail.
  options.workspace = {};
  const Excitation free = optimise_excitation(arm, options);
  const MotionSamples n = fine(free);
  double lowest = kInfinity;
  for (Eigen::Index k = 0; k < n.rows(); k += 10)
    lowest = std::min(lowest, place(arm, n, k, "link7").z());
  EXPECT_LT(lowest, 0.2);
}

TEST(WorkspaceLimits, SpheresKeepTheirClearance) {
  const Model arm = read_model("kuka-lwr4");
  ExcitationOptions options = small_search();
  options.workspace.pairs = {{{"link7", 0.1}, {"world", 0.15, {0.3, 0.0, 0.4}}, 0.02}};
  const Excitation e = optimise_excitation(arm, options);
  ASSERT_EQ(e.status, ExcitationStatus::kDone);
  const MotionSamples m = fine(e);
  for (Eigen::Index k = 0; k < m.rows(); ++k) {
    const double distance = (place(arm, m, k, "link7") - Eigen::Vector3d(0.3, 0.0, 0.4)).norm();
    EXPECT_GE(distance, 0.27 - 1e-9) << k;
  }
}

// The tool of the PSM turns about its remote centre; it is at the centre at 0.4318 - 0.4162 m.
TEST(WorkspaceLimits, InsertionLimitsCountFromTheRemoteCentre) {
  const Model arm = read_model("psm-3dof");
  const VectorXd at_centre = (VectorXd(3) << 0.3, 0.2, 0.4318 - 0.4162).finished();
  const Eigen::Vector3d centre =
      frame_pose(arm, at_centre, *arm.find_frame("tool")).matrix().topRightCorner<3, 1>();
  ExcitationOptions options = small_search();
  options.workspace.insertions = {{"tool", centre, 0.05, 0.15}};
  const Excitation e = optimise_excitation(arm, options);
  ASSERT_EQ(e.status, ExcitationStatus::kDone);
  const MotionSamples m = fine(e);
  const double shift = 0.4318 - 0.4162;
  EXPECT_GE(m.q.col(2).minCoeff(), 0.05 + shift - 1e-4);
  EXPECT_LE(m.q.col(2).maxCoeff(), 0.15 + shift + 1e-4);
  for (const LimitMargin& margin : e.margins) {
    EXPECT_GE(margin.margin, 0.0) << margin.name;
    if (margin.name == "insertion of tool") {
      EXPECT_NEAR(margin.lowest, m.q.col(2).minCoeff() - shift, 1e-3);
    }
  }
}

TEST(WorkspaceLimits, TorquesStayBelowTheEffortOfAnArmWithValues) {
  ModelDescription strong = sample_arms().at("elbow_6R").description();
  for (Coordinate& c : strong.coordinates) {
    c.limits.lower = -2.0;
    c.limits.upper = 2.0;
    c.limits.velocity = 2.0;
    c.limits.effort = kInfinity;
  }
  const Model arm(strong);
  ASSERT_TRUE(arm.inertial_values().has_value());
  const auto largest = [&](const Excitation& e) {
    const MotionSamples m = fine(e);
    VectorXd most = VectorXd::Zero(arm.joints());
    for (Eigen::Index k = 0; k < m.rows(); k += 3) {
      most = most.cwiseMax(inverse_dynamics(arm, m.q.row(k).transpose(), m.dq.row(k).transpose(),
                                            m.ddq.row(k).transpose())
                               .cwiseAbs());
    }
    return most;
  };
  const Excitation free = optimise_excitation(arm, small_search());
  const VectorXd before = largest(free);
  for (int i = 0; i < arm.joints(); ++i)
    strong.coordinates[i].limits.effort = 0.9 * before[i];
  const Excitation e = optimise_excitation(Model(strong), small_search());
  ASSERT_EQ(e.status, ExcitationStatus::kDone);
  const VectorXd after = largest(e);
  for (int i = 0; i < arm.joints(); ++i) EXPECT_LE(after[i], 0.95 * 0.9 * before[i] * (1 + 1e-9));
}

TEST(WorkspaceLimits, InfeasibleLimitsAreReportedWithTheirViolation) {
  const Model arm = read_model("planar-2r");
  ExcitationOptions options = small_search();
  const int last = static_cast<int>(arm.frames().size()) - 1;
  const std::string tip = arm.frames()[last].name;
  options.workspace.boxes = {{tip, {50.0, -kInfinity, -kInfinity}, {51.0, kInfinity, kInfinity}}};
  const Excitation e = optimise_excitation(arm, options);
  EXPECT_EQ(e.status, ExcitationStatus::kLimitsNotMet);
  double worst = 0.0;
  for (const LimitMargin& m : e.margins) {
    if (m.name == "x of " + tip) worst = m.margin;
  }
  EXPECT_LT(worst, -40.0);
  EXPECT_GT(worst, -51.0);
}

TEST(WorkspaceLimits, RefusesUnknownFramesAndCoordinates) {
  const Model arm = read_model("planar-2r");
  ExcitationOptions options = small_search();
  options.workspace.boxes = {{"nowhere", {0, 0, 0}, {1, 1, 1}}};
  EXPECT_THROW(optimise_excitation(arm, options), InvalidInput);
  options.workspace.boxes = {{arm.frames()[0].name, {1, 0, 0}, {0, 1, 1}}};
  EXPECT_THROW(optimise_excitation(arm, options), InvalidInput);
}

}  // namespace
}  // namespace veridyn
