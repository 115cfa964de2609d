#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <cmath>

#include "support/near.hpp"
#include "support/random.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/files/physical_faults.hpp"

// What is known of the robots in data/robots/ from their publications and their construction.

namespace veridyn {
namespace {

// The column of an effect along its axis, by its definition in one line each.
double effect_column(const EffectTerm& term, const State& at) {
  const VectorXd& c = term.axis.coefficients;
  if (term.effect == "rotor_inertia") return c.dot(at.ddq);
  if (term.effect == "viscous_friction") return c.dot(at.dq);
  if (term.effect == "coulomb_friction") return c.dot(at.dq) > 0.0 ? 1.0 : -1.0;
  if (term.effect == "torque_offset") return 1.0;
  EXPECT_EQ(term.effect, "joint_spring");
  const double s = c.dot(at.q);
  return term.values.empty() ? s : std::sin(s + term.values.at("angle"));
}

struct Ranks {
  int inertial;
  int total;
};

int numerical_rank(MatrixXd A) {
  // Columns to one length, but for those that are nothing but rounding.
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    const double length = A.col(j).norm();
    if (length > 1e-9) A.col(j) /= length;
  }
  const VectorXd s = Eigen::JacobiSVD<MatrixXd>(A).singularValues();
  return static_cast<int>((s.array() > 1e-8 * s[0]).count());
}

Ranks base_parameters(const Model& arm) {
  constexpr int kStates = 60;
  const int n = arm.joints();
  const auto bodies = static_cast<Eigen::Index>(kBodyParameters * arm.bodies().size());
  MatrixXd W(kStates * n, bodies + static_cast<Eigen::Index>(arm.effects().size()));
  Random random(51);
  for (int k = 0; k < kStates; ++k) {
    const State at{random.vector(n, -2, 2), random.vector(n, -1, 1), random.vector(n, -3, 3)};
    W.block(k * n, 0, n, bodies) = torque_regressor(arm, at.q, at.dq, at.ddq);
    for (std::size_t e = 0; e < arm.effects().size(); ++e) {
      const EffectTerm& term = arm.effects()[e];
      W.block(k * n, bodies + static_cast<Eigen::Index>(e), n, 1) =
          effect_column(term, at) * term.axis.coefficients;
    }
  }
  return {numerical_rank(W.leftCols(bodies)), numerical_rank(W)};
}

struct Count {
  std::string robot;
  int inertial;
  int total;
};

class BaseParameters : public testing::TestWithParam<Count> {};

// psm-3dof: errata of the thesis; psm-wrist and ur10e: their publications; the textbook arms:
// Mayeda et al. 1990 for chains of revolute joints (planar arm with gravity in the plane 6,
// PUMA-like arm 36).
INSTANTIATE_TEST_SUITE_P(Robot, BaseParameters,
                         testing::Values(Count{"psm-3dof", 16, 25},
                                         Count{"psm-3dof-printed", 19, 28},
                                         Count{"psm-wrist", 17, 49}, Count{"ur10e", 36, 58},
                                         Count{"planar-2r", 6, 10}, Count{"elbow-6r", 36, 52}),
                         [](const auto& test) { return std::to_string(test.index); });

TEST_P(BaseParameters, HaveThePublishedNumber) {
  const Ranks ranks = base_parameters(read_model(GetParam().robot));
  EXPECT_EQ(ranks.inertial, GetParam().inertial) << GetParam().robot;
  EXPECT_EQ(ranks.total, GetParam().total) << GetParam().robot;
}

// A line along z of a pose; `distance` of a point from it.
double distance(const Eigen::Matrix4d& T, const Eigen::Vector3d& point) {
  const Eigen::Vector3d z = T.block<3, 1>(0, 2);
  const Eigen::Vector3d r = point - T.block<3, 1>(0, 3);
  return (r - z * z.dot(r)).norm();
}

struct RemoteCentre {
  std::string robot;
  std::string tool;        // its z axis is the instrument's shaft
  Eigen::Vector3d centre;  // in the world [m]
};

class PatientSideManipulator : public testing::TestWithParam<RemoteCentre> {
 protected:
  static Model arm() { return read_model(GetParam().robot); }
  static Eigen::Matrix4d pose(const Model& arm, const VectorXd& q, const std::string& frame) {
    return frame_pose(arm, q, *arm.find_frame(frame)).matrix();
  }
};

// The centre stands where the yaw axis meets the pitch axis, 0.516 m along the bar from the
// parallelogram.
INSTANTIATE_TEST_SUITE_P(
    Robot, PatientSideManipulator,
    testing::Values(RemoteCentre{"psm-3dof", "tool", {0.516 - 0.0296, 0, 0.1524}},
                    RemoteCentre{"psm-wrist", "insertion", {0, 0.516, 0}},
                    RemoteCentre{"psm-wrist", "roll", {0, 0.516, 0}}),
    [](const auto& test) { return std::to_string(test.index); });

TEST_P(PatientSideManipulator, ShaftPassesThroughTheRemoteCentreInEveryPosture) {
  const Model psm = arm();
  Random random(61);
  for (int trial = 0; trial < 200; ++trial) {
    const VectorXd q = random.vector(psm.joints(), -3, 3);
    EXPECT_LT(distance(pose(psm, q, GetParam().tool), GetParam().centre), 1e-12);
  }
}

TEST_P(PatientSideManipulator, HorizontalBarKeepsItsOrientationInTheYawFrame) {
  const Model psm = arm();
  Random random(62);
  const auto R_yaw_bar = [&](const VectorXd& q) -> Eigen::Matrix3d {
    return pose(psm, q, "yaw").topLeftCorner<3, 3>().transpose() *
           pose(psm, q, "bar").topLeftCorner<3, 3>();
  };
  const Eigen::Matrix3d at_zero = R_yaw_bar(VectorXd::Zero(psm.joints()));
  for (int trial = 0; trial < 50; ++trial) {
    EXPECT_TRUE(near(R_yaw_bar(random.vector(psm.joints(), -3, 3)), at_zero, 1e-14));
  }
}

// Errata: the insertion that puts the tip on the remote centre is 0.4318 m - 0.4162 m.
TEST(Psm3Dof, TipIsAtTheRemoteCentreAtTheInsertionOfTheErrata) {
  const Model psm = read_model("psm-3dof");
  const Eigen::Matrix4d T =
      frame_pose(psm, Eigen::Vector3d(0.4, -0.3, 0.0156), *psm.find_frame("tool")).matrix();
  const Eigen::Vector3d centre(0.4864, 0, 0.1524);
  EXPECT_LT((T.block<3, 1>(0, 3) - centre).norm(), 1e-5);  // the errata print four digits
}

// The row that the errata correct: as printed, no point of the counterweight's way is parallel to
// the insertion.
TEST(Psm3Dof, CounterweightSlidesAgainstTheInsertion) {
  Random random(63);
  for (const bool printed : {false, true}) {
    const Model psm = read_model(printed ? "psm-3dof-printed" : "psm-3dof");
    const VectorXd q = random.vector(3, -1, 1);
    const Eigen::Matrix4d tool = frame_pose(psm, q, *psm.find_frame("tool")).matrix();
    const Eigen::Matrix4d weight = frame_pose(psm, q, *psm.find_frame("counterweight")).matrix();
    const double cosine = tool.block<3, 1>(0, 2).dot(weight.block<3, 1>(0, 2));
    EXPECT_NEAR(cosine, printed ? -std::cos(std::atan(0.0430 / 0.1437)) : -1.0, 1e-14);
  }
}

// The priors of rods and blocks: the arm's own kinematics, and bodies that could exist.
TEST(Rods, HaveTheKinematicsOfTheirArmAndConsistentBodies) {
  Random random(65);
  for (const char* name : {"psm-3dof", "mtm"}) {
    const Model arm = read_model(name);
    const Model rods = read_model(std::string(name) + "-rods");
    ASSERT_EQ(rods.frames().size(), arm.frames().size());
    const VectorXd q = random.vector(arm.joints(), -1, 1);
    for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
      EXPECT_TRUE(
          near(frame_pose(rods, q, {k}).matrix(), frame_pose(arm, q, {k}).matrix(), 1e-15));
    }
    ASSERT_TRUE(rods.inertial_values()) << name;
    EXPECT_TRUE(physical_faults(rods).empty()) << name;
    EXPECT_EQ(rods.description().values, RobotValues::kPrior);
  }
}

TEST(TextbookArms, HavePhysicallyConsistentValues) {
  Random random(64);
  for (const char* name : {"planar-2r", "scara", "elbow-6r"}) {
    const Model arm = read_model(name);
    ASSERT_TRUE(arm.inertial_values()) << name;
    for (int trial = 0; trial < 20; ++trial) {
      const VectorXd q = random.vector(arm.joints(), -2, 2);
      const Eigen::JacobiSVD<MatrixXd> svd(mass_matrix(arm, q));
      EXPECT_GT(svd.singularValues().minCoeff(), 1e-5) << name;
    }
    for (const EffectTerm& term : arm.effects()) EXPECT_FALSE(term.values.empty()) << term.where;
  }
}

}  // namespace
}  // namespace veridyn
