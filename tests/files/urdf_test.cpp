#include "veridyn/files/urdf.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "support/near.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "math/numbers.hpp"
#include "files/output_file.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/files/physical_faults.hpp"

namespace veridyn {
namespace {

const char* const kGripper = R"(<?xml version="1.0"?>
<robot name="gripper">
  <link name="base"/>
  <link name="turret">
    <inertial>
      <origin xyz="0.1 0 0" rpy="1.5707963267948966 0 1.5707963267948966"/>
      <mass value="2"/>
      <inertia ixx="0.03" ixy="0.001" ixz="0" iyy="0.02" iyz="0" izz="0.04"/>
    </inertial>
  </link>
  <link name="left"/>
  <link name="right"/>
  <link name="tip"/>
  <joint name="zeta" type="continuous">
    <parent link="base"/> <child link="turret"/>
    <origin xyz="0 0 0.5" rpy="0 0 0"/> <axis xyz="0 1 0"/>
    <dynamics damping="0.7" friction="0.2"/>
  </joint>
  <joint name="alpha" type="prismatic">
    <parent link="turret"/> <child link="left"/>
    <origin xyz="0.3 0 0" rpy="0 0 0"/> <axis xyz="2 0 0"/>
    <limit lower="0" upper="0.05" velocity="0.1" effort="30"/>
  </joint>
  <joint name="follower" type="prismatic">
    <parent link="turret"/> <child link="right"/>
    <axis xyz="1 0 0"/>
    <limit lower="0" upper="0.05" velocity="0.1" effort="30"/>
    <mimic joint="alpha" multiplier="-0.5" offset="0.2"/>
  </joint>
  <joint name="follower_of_follower" type="revolute">
    <parent link="left"/> <child link="tip"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/>
    <mimic joint="follower" multiplier="10" offset="1"/>
  </joint>
</robot>
)";

class UrdfFile : public testing::Test {
 protected:
  void SetUp() override {
    path_ = (std::filesystem::temp_directory_path() /
             (std::string("veridyn_") +
              testing::UnitTest::GetInstance()->current_test_info()->name() + ".urdf"))
                .string();
  }
  void TearDown() override { std::remove(path_.c_str()); }

  Model read(const std::string& content) {
    write_file(path_, content);
    return read_urdf(path_);
  }

  // The message after the file's name.
  std::string error_of(const std::string& old_text, const std::string& new_text) {
    std::string content = kGripper;
    EXPECT_NE(content.find(old_text), std::string::npos) << old_text;
    content.replace(content.find(old_text), old_text.size(), new_text);
    try {
      read(content);
    } catch (const InvalidInput& error) {
      const std::string message = error.what();
      EXPECT_EQ(message.find(path_), 0U);
      EXPECT_EQ(message.find('\n'), std::string::npos);
      EXPECT_NE(message.find(", expected "), std::string::npos);
      return message.substr(path_.size());
    }
    return "no error";
  }

  std::string path_;
};

TEST_F(UrdfFile, CoordinatesKeepTheOrderOfTheFile) {
  const Model arm = read(kGripper);
  ASSERT_EQ(arm.joints(), 2);
  EXPECT_EQ(arm.coordinates()[0].name, "zeta");
  EXPECT_EQ(arm.coordinates()[1].name, "alpha");
  EXPECT_EQ(arm.coordinates()[1].limits.upper, 0.05);
  EXPECT_EQ(arm.coordinates()[1].limits.effort, 30.0);
  EXPECT_TRUE(std::isinf(arm.coordinates()[0].limits.upper));
}

TEST_F(UrdfFile, MimicJointsBecomeAffineJointVariables) {
  const Model arm = read(kGripper);
  const Frame& right = arm.frames()[arm.find_frame("right")->value];
  EXPECT_TRUE(near(right.variable.coefficients, Eigen::Vector2d(0, -0.5), 0.0));
  EXPECT_EQ(right.variable.offset, 0.2);
  const Frame& tip = arm.frames()[arm.find_frame("tip")->value];
  EXPECT_TRUE(near(tip.variable.coefficients, Eigen::Vector2d(0, -5), 0.0));
  EXPECT_EQ(tip.variable.offset, 3.0);
}

TEST_F(UrdfFile, JointsTurnAndSlideAboutAnyAxis) {
  const Model arm = read(kGripper);
  const double q = 0.3;
  const Eigen::Matrix4d T = frame_pose(arm, Eigen::Vector2d(q, 0.04), *arm.find_frame("left")).matrix();
  // About y: x goes to (cos, 0, -sin). The left finger stands 0.3 + 0.04 along it (URDF axes are
  // directions).
  EXPECT_TRUE(
      near(T.col(3), Eigen::Vector4d(0.34 * std::cos(q), 0, 0.5 - 0.34 * std::sin(q), 1), 1e-15));
  EXPECT_TRUE(near(T.col(0), Eigen::Vector4d(std::cos(q), 0, -std::sin(q), 0), 1e-15));
}

TEST_F(UrdfFile, InertialsAreTurnedIntoTheLinkFrame) {
  const Model arm = read(kGripper);
  InertialParameters phi;  // turned so that x goes to y, y to z and z to x
  phi << 2, 0.2, 0, 0, 0.04, 0, 0.03 + 2 * 0.01, 0, 0.001, 0.02 + 2 * 0.01;
  EXPECT_TRUE(near(*arm.frames()[arm.find_frame("turret")->value].body->phi, phi,
                   1e-15));
}

// A file of the kinematics alone: what moves has a body, whose values are unknown. One inertial makes the others bare frames.
TEST_F(UrdfFile, WithoutAnyInertialEveryMovingLinkHasABodyWithoutValues) {
  std::string content = kGripper;
  const std::size_t begin = content.find("<inertial>"), end = content.find("</inertial>") + std::string("</inertial>").size();
  content.erase(begin, end - begin);
  const Model arm = read(content);
  EXPECT_EQ(arm.bodies().size(), 4U);
  EXPECT_FALSE(arm.inertial_values());
  EXPECT_FALSE(arm.frames()[arm.find_frame("base")->value].body);
  EXPECT_TRUE(physical_faults(arm).empty());
  EXPECT_EQ(read(kGripper).bodies().size(), 1U);
}

TEST_F(UrdfFile, DampingAndFrictionBecomeEffects) {
  const Model arm = read(kGripper);
  ASSERT_EQ(arm.effects().size(), 2U);
  EXPECT_EQ(arm.effects()[0].effect, "viscous_friction");
  EXPECT_EQ(arm.effects()[0].values.at("coefficient"), 0.7);
  EXPECT_EQ(arm.effects()[1].effect, "coulomb_friction");
  EXPECT_EQ(arm.effects()[1].values.at("level"), 0.2);
  const Model again = read(to_urdf(arm));
  ASSERT_EQ(again.effects().size(), 2U);
  EXPECT_EQ(again.effects()[1].values.at("level"), 0.2);
}

// One attribute of <dynamics> does not need the other, and terms of one attribute add up.
TEST_F(UrdfFile, DampingAndFrictionAreWrittenSeparately) {
  struct Term {
    const char* effect;
    double value;
  };
  const auto written = [&](const std::vector<Term>& terms) {
    ModelDescription description = read(kGripper).description();
    description.effects.clear();
    for (const Term& one : terms) {
      EffectTerm term;
      term.effect = one.effect;
      term.axis.coefficients = Eigen::Vector2d(0.0, 1.0);
      term.values[term.effect == "viscous_friction" ? "coefficient" : "level"] = one.value;
      description.effects.push_back(term);
    }
    const Model again = read(to_urdf(Model(description)));
    std::string out;
    for (const EffectTerm& term : again.effects()) {
      EXPECT_TRUE(near(term.axis.coefficients, Eigen::Vector2d(0.0, 1.0), 0.0));
      out += text(term.effect, " ", term.values.begin()->second, ";");
    }
    return out;
  };
  EXPECT_EQ(written({Term{"viscous_friction", 0.75}}), "viscous_friction 0.75;");
  EXPECT_EQ(written({Term{"coulomb_friction", 0.25}}), "coulomb_friction 0.25;");
  EXPECT_EQ(written({Term{"coulomb_friction", 0.25}, Term{"viscous_friction", 0.5}, Term{"viscous_friction", 0.25}}),
            "viscous_friction 0.75;coulomb_friction 0.25;");
  EXPECT_EQ(written({}), "");
}

// A joint that follows another has friction of its own speed; one that does not move has none.
TEST_F(UrdfFile, DampingOfAMimicJointActsOnItsOwnSpeed) {
  std::string content = kGripper;
  const std::string mimic = "<mimic joint=\"alpha\" multiplier=\"-0.5\" offset=\"0.2\"/>", damping = "<dynamics damping=\"3\"/>";
  content.insert(content.find(mimic), damping);
  const Model arm = read(content);
  ASSERT_EQ(arm.effects().size(), 3U);
  EXPECT_EQ(arm.effects()[2].values.at("coefficient"), 3.0);
  EXPECT_TRUE(near(arm.effects()[2].axis.coefficients, Eigen::Vector2d(0.0, -0.5), 0.0));
  content = kGripper;
  content.insert(content.find("</robot>"), "<link name=\"cap\"/><joint name=\"fixed\" type=\"fixed\"><parent link=\"tip\"/><child link=\"cap\"/>" +
                                              damping + "</joint>");
  EXPECT_EQ(read(content).effects().size(), 2U);
}

// 1e10 and more mean "no limit", as exporters write them.
TEST_F(UrdfFile, UnlimitedJointsHaveNoLimits) {
  const auto limits = [&](const std::string& attributes) {
    std::string content = kGripper;
    const std::string old = "lower=\"0\" upper=\"0.05\" velocity=\"0.1\" effort=\"30\"";
    content.replace(content.find(old), old.size(), attributes);
    return read(content).coordinates()[1].limits;
  };
  const Limits own = limits(R"(lower="-1" upper="2" velocity="3" effort="4")");
  EXPECT_EQ(own.lower, -1.0);
  EXPECT_EQ(own.upper, 2.0);
  EXPECT_EQ(own.velocity, 3.0);
  EXPECT_EQ(own.effort, 4.0);
  const Limits zero = limits(R"(lower="0" upper="0" velocity="0" effort="0")");
  const Limits large = limits(R"(lower="-1e16" upper="1e16" velocity="1e16" effort="1e16")");
  const Limits infinite = limits(R"(lower="-1.7e308" upper="1.7e308" velocity="1.7e308" effort="1.7e308")");
  for (const Limits& l : {zero, large, infinite}) {
    EXPECT_EQ(l.lower, -kInfinity);
    EXPECT_EQ(l.upper, kInfinity);
    EXPECT_EQ(l.velocity, kInfinity);
    EXPECT_EQ(l.effort, kInfinity);
  }
}

TEST_F(UrdfFile, SeveralCoordinatesInOneFrameBecomeAChainOfMimicJoints) {
  const std::string urdf = to_urdf(read_model("psm-wrist"));
  EXPECT_NE(urdf.find("<joint name=\"yaw1__pitch_motor\" type=\"continuous\">"), std::string::npos);
  EXPECT_NE(urdf.find("<mimic joint=\"yaw1_motor\" multiplier=\"1.2178\" offset=\"0\"/>"),
            std::string::npos);
}

TEST_F(UrdfFile, IsReadAsAModelByItsPath) {
  write_file(path_, kGripper);
  EXPECT_EQ(read_model(path_).name(), "gripper");
  ModelFileOptions options;
  options.constants["l"] = 1.0;
  EXPECT_THROW(read_model(path_, options), InvalidInput);
}

TEST_F(UrdfFile, InvalidElementsAreRefusedWithLineAndColumn) {
  EXPECT_EQ(error_of("type=\"continuous\"", "type=\"floating\"")
                .find(":14:3: found joint 'zeta' with a floating"),
            0U);
  EXPECT_EQ(error_of("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 0 0\"/>")
                .find(":14:3: found joint 'zeta' with no direction"),
            0U);
  EXPECT_EQ(error_of("lower=\"0\" upper=\"0.05\"", "lower=\"1\" upper=\"0.05\"")
                .find(":19:3: found joint 'alpha' with limits"),
            0U);
  EXPECT_EQ(error_of("mimic joint=\"alpha\"", "mimic joint=\"beta\"")
                .find(":24:3: found joint 'follower' with mimic of"),
            0U);
  EXPECT_EQ(error_of("mimic joint=\"alpha\"", "mimic joint=\"follower\"")
                .find(":24:3: found the joint 'follower' in a cycle"),
            0U);
  EXPECT_EQ(error_of("</robot>", "").find(":35:"), 0U);
  EXPECT_NE(error_of("</robot>", "").find(": found text that is not XML ("), std::string::npos);
  // Each names the joint or link, its line, and what to write.
  const auto expect_words = [&](const std::string& old_text, const std::string& new_text, const std::vector<std::string>& words) {
    const std::string message = error_of(old_text, new_text);
    EXPECT_EQ(message.find(':'), 0U) << message;
    EXPECT_NE(message.find(", expected "), std::string::npos) << message;
    for (const std::string& word : words) EXPECT_NE(message.find(word), std::string::npos) << word << "\n" << message;
  };
  expect_words("<link name=\"tip\"/>", "<link/>", {"a link without a name"});
  expect_words("xyz=\"0.1 0 0\"", "xyz=\"0.1 nan 0\"", {"link 'turret'", "xyz=\"0.1 nan 0\"", "3 finite numbers"});
  expect_words("xyz=\"0.1 0 0\"", "xyz=\"0,1 0 0\"", {"not a comma"});
  expect_words("xyz=\"0.1 0 0\"", "xyz=\"${l} 0 0\"", {"xacro that was not expanded, '${l} 0 0'", "xacro ", " > arm.urdf"});
  expect_words("<link name=\"tip\"/>", "<xacro:link name=\"tip\"/>", {"<xacro:link>"});
  expect_words("<mass value=\"2\"/>", "<mass value=\"two\"/>", {"link 'turret' with mass value=\"two\"", "1 finite number"});
  expect_words("<mass value=\"2\"/>", "", {"link 'turret' with an inertial without a mass"});
  expect_words("<child link=\"turret\"/>", "<child link=\"turet\"/>", {"joint 'zeta' with the child 'turet', which is no link", "did you mean 'turret'?"});
  expect_words("<link name=\"tip\"/>", "<link name=\"tip\"/><link name=\"camera\"/>", {"2 links without a joint above them", "camera", "fixed"});
  expect_words("joint name=\"alpha\"", "joint name=\"zeta\"", {"the second joint 'zeta', after line 14"});
  expect_words(" velocity=", " velocty=", {"with a limit without velocity", "0 for a velocity"});
  expect_words("robot name=", "robot nam=", {"a robot without a name"});
  EXPECT_THROW(read_urdf("/no/such/file.urdf"), InvalidInput);
}

TEST_F(UrdfFile, DamagedFilesAreRefusedAndNeverCrash) {
  const std::string whole = kGripper;
  for (std::size_t k = 0; k < whole.size(); k += 7) {
    for (const char c : {'<', '"', ' ', '\0', '\xff'}) {
      std::string damaged = whole;
      damaged[k] = c;
      try {
        read(damaged);
      } catch (const InvalidInput&) {
      }
    }
  }
}

TEST_F(UrdfFile, ANegativeMassIsRefusedAndANegativeMomentIsNamed) {
  EXPECT_NE(error_of("<mass value=\"2\"/>", "<mass value=\"-1\"/>").find("a mass of -1 kg"), std::string::npos);
  std::string urdf = kGripper;
  urdf.replace(urdf.find("iyy=\"0.02\""), 10, "iyy=\"-0.02\"");
  const std::vector<std::string> faults = physical_faults(read(urdf));
  ASSERT_FALSE(faults.empty());
  EXPECT_NE(faults[0].find("-0.02"), std::string::npos) << faults[0];
}

TEST_F(UrdfFile, NegativeFrictionIsRefused) {
  EXPECT_NE(error_of("damping=\"0.7\"", "damping=\"-0.7\"").find("'zeta' with a damping of -0.7"),
            std::string::npos);
  EXPECT_NE(error_of("friction=\"0.2\"", "friction=\"-0.2\"").find("a friction of -0.2"),
            std::string::npos);
}

TEST_F(UrdfFile, DeepElementsAreRefusedBeforeTheParserRecurses) {
  std::string deep, end;
  for (int k = 0; k < 100000; ++k) {
    deep += "<a>";
    end += "</a>";
  }
  EXPECT_NE(error_of("<link name=\"base\"/>", "<link name=\"base\"/>" + deep + end)
                .find("elements nested deeper than 500"),
            std::string::npos);
  // Brackets in comments, values and declarations are no elements.
  std::string flat = kGripper;
  for (int k = 0; k < 200; ++k) flat.insert(flat.find("<link"), "<!-- <a> <b> --><note name='<a>'/>");
  EXPECT_EQ(error_of(kGripper, flat), "no error");
}

std::vector<std::string> faults_with(const Model& arm, const std::string& link, double mass,
                                     const Eigen::Matrix<double, 6, 1>& inertia) {
  ModelDescription changed = arm.description();
  changed.frames[arm.find_frame(link)->value].body->phi =
      inertial_parameters(mass, {0.1, 0, 0}, inertia);
  return physical_faults(Model(changed));
}

TEST_F(UrdfFile, UnsupportedJointsAreNamed) {
  const Model arm = read(kGripper);
  Eigen::Matrix<double, 6, 1> plate, beyond;  // xx, xy, yy, xz, yz, zz
  plate << 0.01, 0, 0.01, 0, 0, 0.0201;
  beyond << 0.01, 0, 0.01, 0, 0, 0.021;
  EXPECT_EQ(faults_with(arm, "turret", 2.0, plate), std::vector<std::string>{"'alpha' moves no mass"});
  const std::vector<std::string> found = faults_with(arm, "turret", 2.0, beyond);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].find("'turret' has principal moments"), 0U);
  const std::vector<std::string> massless = faults_with(arm, "turret", 0.0, plate);
  ASSERT_EQ(massless.size(), 3U);  // the body, and both coordinates
  EXPECT_EQ(massless[0], "'turret' has moments of inertia and no mass");
  EXPECT_EQ(massless[1], "'zeta' moves no mass");
}

}  // namespace
}  // namespace veridyn
