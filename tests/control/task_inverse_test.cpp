#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "control/control_support.hpp"
#include "veridyn/control/inverse_kinematics.hpp"
#include "veridyn/control/task_inverse.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

MatrixXd jacobian_at(const Model& arm, const VectorXd& q) {
  TipKinematics tip(arm, {last_frame(arm)});
  tip.update(q, VectorXd::Zero(arm.joints()));
  return tip.jacobian();
}

TEST(TaskInverse, AwayFromSingularitiesThePostureUsesOnlyTheNullSpace) {
  for (const auto& [name, rows] :
       {std::pair("elbow_6R", TaskRows::kPose), std::pair("serial_RRPRRPR", TaskRows::kPose),
        std::pair("serial_RRPRRPR", TaskRows::kPosition)}) {
    const Model& arm = sample_arms().at(name);
    TaskInverse inverse(arm, {last_frame(arm)}, rows);
    Random random(7);
    VectorXd y(arm.joints());
    VectorXd y_other(arm.joints());
    const auto used = static_cast<Eigen::Index>(inverse.rows());
    for (int k = 0; k < 8; ++k) {
      const MatrixXd J = jacobian_at(arm, random.vector(arm.joints(), -1.5, 1.5));
      const Vector6d a = random.vector(6, -1, 1);
      const VectorXd y0 = random.vector(arm.joints(), -1, 1);
      inverse.update(J);
      if (inverse.near_singular()) continue;
      inverse.solve(a, VectorXd::Zero(arm.joints()), y);
      inverse.solve(a, y0, y_other);
      EXPECT_TRUE(near((J * y).head(used), a.head(used), 1e-9));
      EXPECT_TRUE(near((J * y_other).head(used), a.head(used), 1e-9));
      EXPECT_EQ((y - y_other).norm() > 1e-2, arm.joints() > used);
    }
  }
}

// The inverse as its definition says, from a singular value decomposition: poses where no direction is
// damped take a Cholesky factor, the others eigenvectors. The threshold is half way between the poses.
TEST(TaskInverse, EqualsTheDampedInverseOfASingularValueDecomposition) {
  constexpr double kLength = 0.5;
  constexpr int kPoses = 64;
  const Model& arm = sample_arms().at("serial_RRPRRPR");
  VectorXd unit = VectorXd::Ones(arm.joints());
  for (int i = 0; i < arm.joints(); ++i) {
    if (arm.coordinates()[i].prismatic) unit[i] = kLength;
  }
  Vector6d weight = Vector6d::Ones();
  weight.head<3>().setConstant(1.0 / kLength);
  for (const TaskRows rows : {TaskRows::kPosition, TaskRows::kPose}) {
    const auto used = static_cast<Eigen::Index>(rows);
    Random random(8);
    std::vector<MatrixXd> jacobians;
    std::vector<Eigen::JacobiSVD<MatrixXd>> parts;
    std::vector<double> smallest;
    for (int k = 0; k < kPoses; ++k) {
      jacobians.push_back(jacobian_at(arm, random.vector(arm.joints(), -1.5, 1.5)));
      const MatrixXd normal = (weight.asDiagonal() * jacobians.back() * unit.asDiagonal()).topRows(used);
      parts.emplace_back(normal, Eigen::ComputeThinU | Eigen::ComputeThinV);
      smallest.push_back(parts.back().singularValues()[used - 1]);
    }
    std::vector<double> sorted = smallest;
    std::sort(sorted.begin(), sorted.end());
    const double threshold = 0.5 * (sorted[kPoses / 2 - 1] + sorted[kPoses / 2]);
    TaskInverse inverse(arm, {last_frame(arm)}, rows, {kLength, threshold});
    VectorXd y(arm.joints());
    int damped = 0;
    for (int k = 0; k < kPoses; ++k) {
      const Vector6d a = random.vector(6, -1, 1);
      VectorXd gain = parts[k].singularValues();
      for (double& s : gain) s /= std::pow(std::max(s, threshold), 2);
      const VectorXd expected =
          unit.cwiseProduct(parts[k].matrixV() * gain.asDiagonal() * parts[k].matrixU().transpose() *
                            weight.cwiseProduct(a).head(used));
      inverse.update(jacobians[k]);
      inverse.solve(a, VectorXd::Zero(arm.joints()), y);
      EXPECT_TRUE(near(y, expected, 1e-12 * (1.0 + expected.norm())));
      EXPECT_EQ(inverse.near_singular(), smallest[k] < threshold);
      EXPECT_NEAR(inverse.smallest_singular_value(), smallest[k], 1e-12);
      damped += inverse.near_singular() ? 1 : 0;
    }
    EXPECT_EQ(damped, kPoses / 2);
  }
}

// The smallest singular value is that of the normalised Jacobian, and no direction of the task
// costs more than 1 / threshold, singular poses included.
TEST(TaskInverse, ThroughASingularPoseTheJointsStayBoundedAndContinuous) {
  const Model arm = read_model("psm-3dof");  // singular where the tip is on the remote centre
  const Tip tip{"tool"};
  TaskInverse inverse(arm, tip, TaskRows::kPosition);
  const double L = inverse.length();
  EXPECT_GT(L, 0.05);
  EXPECT_LT(L, 0.3);
  TipKinematics kinematics(arm, tip);
  VectorXd y(3);
  VectorXd last(3);
  const VectorXd rest = VectorXd::Zero(3);
  Vector6d a = Vector6d::Zero();
  a.head<3>() << 0.3 * L, -0.2 * L, 0.1 * L;
  bool singular = false;
  for (int k = 0; k <= 400; ++k) {
    VectorXd q(3);
    q << 0.3, -0.2, 0.0156 - 0.02 + 1e-4 * k;
    kinematics.update(q, rest);
    const MatrixXd& J = kinematics.jacobian();
    inverse.update(J);
    MatrixXd normal = J.topRows<3>() / L;
    normal.col(2) *= L;
    const Eigen::JacobiSVD<MatrixXd> svd(normal);
    EXPECT_NEAR(inverse.smallest_singular_value(), svd.singularValues()[2], 1e-7);
    singular = singular || inverse.smallest_singular_value() < 1e-3;
    inverse.solve(a, rest, y);
    const Eigen::Vector3d normal_y(y[0], y[1], y[2] / L);
    EXPECT_LE(normal_y.norm(), a.norm() / L / 0.05 * (1 + 1e-9));
    // A step of 0.1 mm cannot change the answer by more than the damped inverse's slope allows.
    EXPECT_LT(k == 0 ? 0.0 : (y - last).norm(), 0.25);
    last = y;
  }
  EXPECT_TRUE(singular);
}

// Metres or millimetres: the same arm, the same motion.
TEST(TaskInverse, TheUnitOfLengthDoesNotChangeTheMotion) {
  const Model arm = read_model("psm-3dof");
  ModelDescription millimetres = arm.description();
  for (Frame& frame : millimetres.frames) {
    for (Posed* T : {&frame.A, &frame.B}) T->p = 1000.0 * T->p;
    if (frame.type == JointType::kPrismatic) frame.variable.offset *= 1000.0;
  }
  millimetres.coordinates[2].limits.upper *= 1000.0;
  const Model big(std::move(millimetres));
  const Tip tip{"tool"};
  TaskInverse metre(arm, tip, TaskRows::kPosition);
  TaskInverse milli(big, tip, TaskRows::kPosition);
  EXPECT_NEAR(milli.length(), 1000.0 * metre.length(), 1e-6);
  VectorXd y(3);
  VectorXd y_milli(3);
  const VectorXd rest = VectorXd::Zero(3);
  for (const double depth : {0.0160, 0.03, 0.2}) {
    const Eigen::Vector3d q(0.4, 0.3, depth);
    metre.update(jacobian_at(arm, q));
    TipKinematics near_tip(arm, tip);
    near_tip.update(q, rest);
    metre.update(near_tip.jacobian());
    TipKinematics far_tip(big, tip);
    far_tip.update(Eigen::Vector3d(0.4, 0.3, 1000.0 * depth), rest);
    milli.update(far_tip.jacobian());
    Vector6d a = Vector6d::Zero();
    a.head<3>() << 0.01, 0.02, -0.03;
    metre.solve(a, rest, y);
    milli.solve(1000.0 * a, rest, y_milli);
    EXPECT_TRUE(near(Eigen::Vector3d(y[0], y[1], 1000.0 * y[2]), y_milli, 1e-9));
  }
}

Model with_limits(const Model& arm, double range) {
  ModelDescription description = arm.description();
  for (Coordinate& c : description.coordinates) {
    c.limits.lower = -range;
    c.limits.upper = range;
  }
  return Model(std::move(description));
}

TEST(InverseKinematics, FindsThePoseOfRandomJointsFromNearby) {
  for (const char* name : {"elbow_6R", "serial_RRPRRPR", "coupled_wrist", "spherical_RRP"}) {
    const Model& arm = sample_arms().at(name);
    InverseKinematicsOptions options;
    options.rows = arm.joints() >= 6 ? TaskRows::kPose : TaskRows::kPosition;
    options.inverse.threshold = 0.01;
    InverseKinematics inverse(arm, {last_frame(arm)}, options);
    const FrameIndex frame{static_cast<int>(arm.frames().size()) - 1};
    Random random(17);
    int found = 0;
    for (int k = 0; k < 20; ++k) {
      const VectorXd q = random.vector(arm.joints(), -1.2, 1.2);
      const Eigen::Matrix4d T = frame_pose(arm, q, frame).matrix();
      VectorXd solution = q + random.vector(arm.joints(), -0.3, 0.3);
      const ReachStatus status =
          inverse.solve(T.topRightCorner<3, 1>(), T.topLeftCorner<3, 3>(), solution);
      if (status != ReachStatus::kReached) continue;
      ++found;
      const Eigen::Matrix4d reached = frame_pose(arm, solution, frame).matrix();
      EXPECT_TRUE(near(reached.topRightCorner<3, 1>(), T.topRightCorner<3, 1>(), 1e-6));
      if (options.rows == TaskRows::kPosition) continue;
      EXPECT_TRUE(near(reached.topLeftCorner<3, 3>(), T.topLeftCorner<3, 3>(), 1e-6));
    }
    EXPECT_GE(found, 18) << name;
  }
}

TEST(InverseKinematics, JointLimitsHoldAtReachablePositions) {
  const Model arm = with_limits(sample_arms().at("serial_RRPRRPR"), 0.6);
  const FrameIndex frame{static_cast<int>(arm.frames().size()) - 1};
  InverseKinematics inverse(arm, {last_frame(arm)});
  Random random(19);
  int found = 0;
  int at_limit = 0;
  for (int k = 0; k < 30; ++k) {
    // Reachable within the limits by construction; seven joints for three numbers.
    VectorXd q = random.vector(7, -0.6, 0.6);
    for (double& angle : q) angle = std::copysign(0.55, angle);
    const Eigen::Matrix4d T = frame_pose(arm, q, frame).matrix();
    VectorXd solution = VectorXd::Zero(7);
    const ReachStatus status =
        inverse.solve(T.topRightCorner<3, 1>(), Eigen::Matrix3d::Identity(), solution);
    EXPECT_LE(solution.cwiseAbs().maxCoeff(), 0.6);
    if (solution.cwiseAbs().maxCoeff() == 0.6) ++at_limit;
    if (status == ReachStatus::kReached) ++found;
  }
  EXPECT_GE(found, 28);
  EXPECT_GE(at_limit, 3);
}

TEST(InverseKinematics, UnreachablePosesAreReportedWithTheNearestSolution) {
  const Model arm = sample_arms().at("planar_2R");  // both links in a vertical plane
  ModelDescription description = arm.description();
  description.frames.back().B.p = {0.3, 0, 0};
  const Model longer{std::move(description)};
  InverseKinematicsOptions options;
  options.most_iterations = 200;
  InverseKinematics inverse(longer, {last_frame(longer)}, options);
  VectorXd q(2);
  q << 0.4, 0.9;
  const Eigen::Vector3d far(1.0, 0.0, 0.0);
  EXPECT_EQ(inverse.solve(far, Eigen::Matrix3d::Identity(), q), ReachStatus::kNotReached);
  // Reach is 0.4 + 0.3: 0.3 m are missing.
  EXPECT_NEAR(inverse.position_error(), 0.3, 2e-3);
  q << 0.4, 0.9;
  const Eigen::Vector3d nowhere(NAN, 0.0, 0.0);
  EXPECT_EQ(inverse.solve(nowhere, Eigen::Matrix3d::Identity(), q), ReachStatus::kNotReached);
  EXPECT_TRUE(near(q, Eigen::Vector2d(0.4, 0.9), 0.0));
  EXPECT_THROW(InverseKinematics(longer, {"nowhere"}), InvalidInput);
}

}  // namespace
}  // namespace veridyn
