#include <gtest/gtest.h>

#include "recordings/signals/joint_fields.hpp"
#include "recordings/fields/joint_match.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::recordings {
namespace {

using Names = std::vector<std::string>;

struct Column {
  const char* name;
  int signal;  // q, dq, ddq, tau, i; -1: none
  const char* joint;
};

TEST(TheNameOfAColumn, DeterminesSignalAndJoint) {
  const Column columns[] = {{"q1", 0, "1"},
                            {"actual_q_0", 0, "0"},
                            {"actual_qd_3", 1, "3"},
                            {"actual_current_5", 4, "5"},
                            {"elbow_joint/position", 0, "elbow_joint"},
                            {"pos.elbow_joint", 0, "elbow_joint"},
                            {"elbow.vel [deg/s]", 1, "elbow"},
                            {"tau_J/0", 3, "0"},
                            {"qfrc_actuator[0]", 3, "0"},
                            {"qpos0", 0, "0"},
                            {"theta_dot_1", 1, "1"},
                            {"qddot2", 2, "2"},
                            {"Joint 1 Position (deg)", 0, "Joint 1"},
                            {"elbow_motor_current", 4, "elbow"},
                            {"joint_position_1", 0, "1"},
                            {"q(elbow)", 0, "elbow"},
                            {"shoulderPosition", 0, "shoulder"},
                            {"joint_1_effort", 3, "joint_1"},
                            {"torque", 3, "1"},
                            {"target_q_0", -1, ""},
                            {"q_d/0", -1, ""},
                            {"setpoint_position_1", -1, ""},
                            {"wrench/force/z", -1, ""},
                            {"actual_TCP_pose_0", -1, ""},
                            {"actual_TCP_speed_0", -1, ""},
                            {"temperature_3", -1, ""},
                            {"__time", -1, ""}};
  for (const Column& column : columns) {
    const RawField field = field_of(column.name);
    EXPECT_EQ(field.signal, column.signal) << column.name;
    EXPECT_EQ(field.joint, column.joint) << column.name;
  }
}

// Names as the drivers of these arms publish them.
TEST(Joints, AreMatchedByTheirNames) {
  EXPECT_EQ(match_joints({"shoulder_pan", "shoulder_lift", "elbow", "wrist_1"},
                         {"elbow_joint", "shoulder_lift_joint", "shoulder_pan_joint",
                          "wrist_1_joint", "wrist_2_joint"},
                         {}),
            (std::vector<int>{2, 1, 0, 3}));
  EXPECT_EQ(match_joints({"yaw", "pitch", "insertion"},
                         {"outer_yaw", "outer_pitch", "outer_insertion", "outer_roll",
                          "outer_wrist_pitch", "outer_wrist_yaw"},
                         {}),
            (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(match_joints({"a1", "a2", "e1"}, {"lwr_a2_joint", "lwr_e1_joint", "lwr_a1_joint"}, {}),
            (std::vector<int>{2, 0, 1}));
  EXPECT_EQ(match_joints({"joint1", "joint2"},
                         {"panda_finger_joint1", "panda_joint2", "panda_joint1", "panda_finger_joint2"}, {}),
            (std::vector<int>{2, 1}));
}

TEST(Joints, AreMatchedByTheirNumbersIfNoNameMatches) {
  EXPECT_EQ(match_joints({"a1", "a2", "e1"}, {"iiwa_joint_3", "iiwa_joint_1", "iiwa_joint_2"}, {}),
            (std::vector<int>{1, 2, 0}));
  EXPECT_EQ(match_joints({"wrist_1", "wrist_2"}, {"0", "1"}, {}), (std::vector<int>{0, 1}));
  EXPECT_EQ(match_joints({"wrist_1", "wrist_2"}, {"1", "2", "3"}, {}), (std::vector<int>{0, 1}));
  // A hole in the numbers leaves open which is which.
  EXPECT_EQ(match_joints({"yaw", "pitch"}, {"joint_1", "joint_3"}, {}), (std::vector<int>{-1, -1}));
}

TEST(Joints, WithUnknownNamesAreNotMatchedByTheirPosition) {
  EXPECT_EQ(match_joints({"yaw", "pitch"}, {"alpha", "beta"}, {}), (std::vector<int>{-1, -1}));
  EXPECT_EQ(match_joints({"yaw", "pitch"}, {"alpha", "pitch"}, {}), (std::vector<int>{-1, 1}));
}

TEST(Joints, AreMatchedByTheGivenNames) {
  EXPECT_EQ(match_joints({"yaw", "pitch"}, {"alpha", "pitch"}, {{"yaw", "alpha"}}),
            (std::vector<int>{0, 1}));
  EXPECT_THROW(match_joints({"yaw"}, {"alpha"}, {{"yaw", "gamma"}}), InvalidInput);
}

TEST(Joints, ThatFitTwoNamesEquallyAreRefused) {
  try {
    match_joints({"yaw"}, {"left_yaw", "right_yaw"}, {});
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_STREQ(error.what(),
                 "found 'left_yaw' and 'right_yaw', either may be joint yaw, expected --map yaw=NAME.");
  }
}

}  // namespace
}  // namespace veridyn::recordings
