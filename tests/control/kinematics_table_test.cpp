#include "control/kinematics_table.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "veridyn/kinematics/kinematics.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

// What forward kinematics gives, inverse kinematics takes back.
TEST(KinematicsTable, InverseInvertsForwardKinematics) {
  for (const char* name : {"psm-3dof", "ur10e"}) {
    SCOPED_TRACE(name);
    const Model arm = read_model(name);
    const std::string frame = arm.frames().back().name == "counterweight" ? "tool" : arm.frames().back().name;
    const KinematicTable there = sample_workspace(arm, frame, 20);
    InverseTask task;
    task.has_orientation = std::string(name) == "ur10e";
    for (const KinematicRow& row : there.rows) task.poses.push_back(row.T_world_tip);
    const KinematicTable back = inverse_kinematics(arm, frame, task);
    int reached = 0;
    for (const KinematicRow& row : back.rows) {
      if (row.status != ReachStatus::kReached) continue;
      ++reached;
      EXPECT_LT(row.position_error, 1e-6);
      EXPECT_LT(row.angle_error, 1e-6);
    }
    EXPECT_EQ(reached, 20);
  }
}

// A planar arm of rods 0.5 m and 0.4 m: its Jacobian and singular postures by hand.
TEST(KinematicsTable, ThePlanarArmIsSingularWhereItIsStretched) {
  const Model arm = read_model("planar-2r");
  MatrixXd q(2, 2);
  q << 0.3, 0.0, 0.3, M_PI / 2;
  const KinematicTable table = forward_kinematics(arm, "fore", q);
  const double y = 0.5 * std::sin(0.3) + 0.4 * std::sin(0.3);
  EXPECT_NEAR(table.rows[0].jacobian(0, 0), -y, 1e-12);
  // The third row is the axis of the plane: only motion in it counts, and it is lost there.
  EXPECT_LT(table.rows[0].position.manipulability, 1e-7)  // the root of rounding
     ;
  EXPECT_THROW(forward_kinematics(arm, "fore", MatrixXd::Zero(1, 3)), InvalidInput);
}

}  // namespace
}  // namespace veridyn
