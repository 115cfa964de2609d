#include "veridyn/effects/cause.hpp"

#include <gtest/gtest.h>

#include "effects/kinematic_error.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

Model psm() {
  return read_model("psm-3dof");
}

std::string refusal(const std::string& words) {
  try {
    parse_cause(psm(), words);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

// Every number of every frame, of rows and of origins, is set alone: the others keep their values.
TEST(Cause, SettingOneFrameConstantKeepsAllOthers) {
  std::map<std::string, Model> arms = sample_arms();
  arms.emplace("psm-3dof", psm());
  int rows = 0, origins = 0;
  for (const auto& [name, arm] : arms) {
    std::vector<FrameConstant> all;
    for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
      for (const FrameConstant& c : constants_of(arm, {k})) {
        // Roll and yaw of an upright origin are not unique.
        const double pitch = value_of({FrameConstant{{k}, FrameNumber::kPitch}}, arm.description());
        const bool upright = !arm.frames()[k].dh && std::abs(pitch) > 1.5;
        const bool turns = unit_of(c) == "rad";
        if (!upright || !turns) all.push_back(c);
      }
    }
    for (const FrameConstant& c : all) {
      (arm.frames()[c.frame.value].dh ? rows : origins) += 1;
      ModelDescription d = arm.description();
      set_value({c}, value_of({c}, d) + 0.01, d);
      for (const FrameConstant& other : all) {
        const bool same = other.frame == c.frame && other.number == c.number && other.joint == c.joint;
        const double error = value_of({other}, d) - value_of({other}, arm.description()) - (same ? 0.01 : 0.0);
        EXPECT_NEAR(unit_of(other) == "rad" ? std::remainder(error, 2.0 * M_PI) : error, 0.0, 1e-9)  // angles by whole turns
            << name << ": " << to_text(arm, KinematicError{c}) << ", " << name_of(arm, other);
      }
    }
  }
  EXPECT_GT(rows, 30);
  EXPECT_GT(origins, 30);
}

// What is printed is read back as the same cause, for every effect at every place that it can have.
TEST(Cause, TextFormRoundTrips) {
  const Model arm = psm();
  std::vector<Cause> causes;
  for (int i = 0; i < arm.joints(); ++i) {
    for (const AxisEffect* effect : axis_effects())
      causes.emplace_back(NewEffect{effect->name(), {i}});
    for (const ChannelEffect* effect : channel_effects()) {
      if (!effect->whole_arm()) causes.emplace_back(ChannelError{effect->name(), JointIndex{i}});
    }
    causes.emplace_back(ExternalContact{{i}});
  }
  for (const ChannelEffect* effect : channel_effects())
    causes.emplace_back(ChannelError{effect->name(), std::nullopt});
  for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
    causes.emplace_back(AddedLoad{{k}});
    causes.emplace_back(AddedInertia{{k}});
  }
  for (const auto& [name, value] : arm.description().constants)
    causes.emplace_back(KinematicError{NamedConstant{name}});
  for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
    for (const FrameConstant& c : constants_of(arm, {k})) causes.emplace_back(KinematicError{c});
  }
  for (int i = 0; i < arm.joints(); ++i)
    causes.emplace_back(KinematicError{JointZero{{i}}});
  ASSERT_GT(causes.size(), 60U);
  for (const Cause& cause : causes) {
    const std::string words = to_text(arm, cause);
    const Cause again = parse_cause(arm, words);
    EXPECT_EQ(again.index(), cause.index()) << words;
    EXPECT_EQ(effect_of(again), effect_of(cause)) << words;
    EXPECT_EQ(joint_of(again), joint_of(cause)) << words;
    EXPECT_EQ(frame_of(again), frame_of(cause)) << words;
    EXPECT_EQ(to_text(arm, again), words);
  }
}

TEST(Cause, ReadsJointsByNumberFromOneOrByName) {
  const Model arm = psm();
  for (int i = 0; i < arm.joints(); ++i) {
    const std::string name = arm.coordinates()[i].name;
    EXPECT_EQ(joint_of(parse_cause(arm, "backlash:" + std::to_string(i + 1)))->value, i);
    EXPECT_EQ(joint_of(parse_cause(arm, "backlash:" + name))->value, i);
  }
  EXPECT_EQ(to_text(arm, parse_cause(arm, "gravity_tilt")), "gravity_tilt:arm");
  EXPECT_EQ(to_text(arm, parse_cause(arm, "time_delay:arm")), "time_delay:arm");
}

TEST(Cause, RejectsUnknownNamesAndListsKnownOnes) {
  EXPECT_NE(refusal("backlash:yau").find("did you mean 'yaw'?"), std::string::npos);
  EXPECT_NE(refusal("backlash:4").find("expected a number from 1 to 3 or one of: yaw"),
            std::string::npos);
  EXPECT_NE(refusal("backlash:0").find("found the joint '0'"), std::string::npos);
  EXPECT_NE(refusal("backlash").find("found the joint ''"), std::string::npos);
  EXPECT_NE(refusal("backlahs:1").find("did you mean 'backlash'?"), std::string::npos);
  EXPECT_NE(refusal("payload:tol").find("found the frame 'tol'"), std::string::npos);
  EXPECT_NE(refusal("gravity_tilt:yaw").find("expected 'arm'"), std::string::npos);
  EXPECT_NE(refusal("coupling_error:yaw.beta").find("as in FRAME.theta"), std::string::npos);
  EXPECT_NE(refusal("coupling_error:gamma").find("expected a constant of the robot file"),
            std::string::npos);
}

// A load and a number of a frame's row act where the last joint moves the frame.
TEST(Cause, ALoadActsAtTheLastJointThatMovesItsFrame) {
  const Model arm = psm();
  const FrameIndex tool = *arm.find_frame("tool");
  EXPECT_EQ(acting_joint(arm, AddedLoad{tool}), JointIndex{2});
  EXPECT_EQ(acting_joint(arm, KinematicError{FrameConstant{tool, FrameNumber::kTheta}}), JointIndex{2});
  EXPECT_EQ(acting_joint(arm, NewEffect{"backlash", {1}}), JointIndex{1});
  EXPECT_FALSE(acting_joint(arm, ChannelError{"gravity_tilt", std::nullopt}).has_value());
  const CauseWords w = words_of(arm, AddedLoad{tool});
  EXPECT_EQ(w.effect, "payload");
  EXPECT_EQ(w.joint, JointIndex{2});
  EXPECT_EQ(w.coordinate, "insertion");
  EXPECT_EQ(w.frame, "tool");
  const CauseWords of_arm = words_of(arm, ChannelError{"time_delay", std::nullopt});
  EXPECT_FALSE(of_arm.joint);
  EXPECT_EQ(of_arm.coordinate, "arm");
  EXPECT_TRUE(same_cause(NewEffect{"backlash", {1}}, ChangedEffect{"backlash", {1}}));
  EXPECT_FALSE(same_cause(NewEffect{"backlash", {1}}, NewEffect{"backlash", {2}}));
}

// Whatever turned gravity, the roll and pitch that are said turn it there.
TEST(GravityTilt, RollAndPitchBetweenTwoGravitiesMapOneToTheOther) {
  const auto& tilt = dynamic_cast<const ArmEffect&>(find_effect("gravity_tilt"));
  for (const Eigen::Vector3d& gravity : {Eigen::Vector3d(0.0, 0.0, -9.81), Eigen::Vector3d(9.81, 0.0, 0.0), Eigen::Vector3d(3.0, 5.0, -7.0)}) {
    for (const auto& [roll, pitch] : {std::pair(0.02, -0.01), std::pair(M_PI, 0.0), std::pair(1.6, 0.3), std::pair(-2.5, 1.2)}) {
      ModelDescription before = read_model("planar-2r").description();
      before.gravity = gravity;
      ModelDescription after = before;
      tilt.change(after, {roll, pitch});
      const std::vector<double> found = tilt.values_between(before, after, {7.0, 7.0});
      EXPECT_LE(std::abs(found[0]), M_PI + 1e-9);
      EXPECT_LE(std::abs(found[1]), M_PI + 1e-9);
      ModelDescription again = before;
      tilt.change(again, found);
      EXPECT_LT((again.gravity - after.gravity).norm(), 1e-6) << gravity.transpose() << " " << roll << " " << pitch;
    }
  }
}

}  // namespace
}  // namespace veridyn
