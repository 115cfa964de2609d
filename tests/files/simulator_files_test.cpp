#include "veridyn/files/simulator_files.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include "math/numbers.hpp"
#include "support/near.hpp"
#include "support/refusal.hpp"
#include "support/sample_arms.hpp"
#include "support/stranger_files.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/files/mjcf.hpp"
#include "veridyn/files/sdf.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/files/urdf.hpp"
#include "veridyn/simulation/joint_torques.hpp"
#include "veridyn/simulation/plausible_model.hpp"

// An exported file is read back as the same arm.

namespace veridyn {
namespace {

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string path = (std::filesystem::temp_directory_path() / "veridyn-simulator-files-XXXXXX").string();
    require(mkdtemp(path.data()) != nullptr, path, ": cannot be made.");
    path_ = path;
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string write(const std::string& name, const std::string& content) const {
    std::ofstream(path_ / name) << content;
    return (path_ / name).string();
  }

 private:
  std::filesystem::path path_;
};

// The coordinates of `b` in the order of `a`'s.
MatrixXd permutation(const Model& a, const Model& b) {
  MatrixXd P = MatrixXd::Zero(a.joints(), b.joints());
  for (int i = 0; i < a.joints(); ++i) {
    if (const auto j = b.find_coordinate(a.coordinates()[i].name)) P(i, j->value) = 1.0;
  }
  return P;
}

void expect_same_frames(const Model& before, const Model& after) {
  ASSERT_EQ(after.joints(), before.joints());
  const MatrixXd P = permutation(before, after);
  ASSERT_EQ(P.sum(), before.joints());
  std::srand(4);
  for (int trial = 0; trial < 5; ++trial) {
    const VectorXd q = VectorXd::Random(before.joints());
    for (std::size_t k = 0; k < before.frames().size(); ++k) {
      std::optional<FrameIndex> there = after.find_frame(before.frames()[k].name);
      if (!there) there = after.find_frame(before.frames()[k].name + "_link");  // see to_sdf()
      ASSERT_TRUE(there) << before.frames()[k].name;
      const Eigen::Isometry3d T = frame_pose(before, q, {static_cast<int>(k)});
      const Eigen::Isometry3d U = frame_pose(after, P.transpose() * q, *there);
      EXPECT_TRUE(near(T.matrix(), U.matrix(), 1e-12)) << before.frames()[k].name;
    }
  }
}

void expect_same_torques(const Model& before, const Model& after) {
  const MatrixXd P = permutation(before, after);
  std::srand(8);
  for (int trial = 0; trial < 10; ++trial) {
    const VectorXd q = VectorXd::Random(before.joints());
    const VectorXd dq = VectorXd::Random(before.joints());
    const VectorXd ddq = VectorXd::Random(before.joints());
    const VectorXd tau = joint_torques(before, q, dq, ddq);
    const VectorXd read = P * joint_torques(after, P.transpose() * q, P.transpose() * dq, P.transpose() * ddq);
    EXPECT_TRUE(near(read, tau, 1e-9 * (1.0 + tau.cwiseAbs().maxCoeff())));
  }
}

// Effects that the format has words for.
Model with_effects(const Model& arm, const std::vector<std::string>& known) {
  ModelDescription d = arm.description();
  d.effects.clear();
  for (int i = 0; i < arm.joints(); ++i) {
    const auto add = [&](const char* effect, const char* key, double value, double offset) {
      if (std::find(known.begin(), known.end(), effect) == known.end()) return;
      EffectTerm term;
      term.effect = effect;
      term.axis = {VectorXd::Unit(arm.joints(), i), offset};
      term.values[key] = value;
      d.effects.push_back(term);
    };
    add("viscous_friction", "coefficient", 0.3 + 0.1 * i, 0.0);
    add("coulomb_friction", "level", 0.7 - 0.05 * i, 0.0);
    add("rotor_inertia", "inertia", 0.01 * (i + 1), 0.0);
    add("joint_spring", "stiffness", 2.0 + i, 0.1 * i - 0.2);
  }
  // A constant force becomes part of a spring where the joint has one.
  return Model(std::move(d));
}

class SimulatorFiles : public testing::TestWithParam<std::string> {
 protected:
  TemporaryFolder folder_;
};

TEST_P(SimulatorFiles, MjcfIsReadBackAsTheArm) {
  const Model arm = with_effects(plausible_model(read_model(GetParam()), 3).arm,
                                 {"viscous_friction", "coulomb_friction", "rotor_inertia", "joint_spring"});
  const Model read = read_model(folder_.write("arm.xml", to_mjcf(arm)));
  expect_same_frames(arm, read);
  expect_same_torques(arm, read);
  EXPECT_EQ(read.effects().size(), arm.effects().size());
  for (const Coordinate& c : arm.coordinates()) {
    const Coordinate& other = read.coordinates()[read.find_coordinate(c.name)->value];
    EXPECT_EQ(other.prismatic, c.prismatic);
    EXPECT_EQ(other.limits.effort, c.limits.effort);
    const bool both = std::isfinite(c.limits.lower) && std::isfinite(c.limits.upper);
    if (!both) continue;
    EXPECT_NEAR(other.limits.lower, c.limits.lower, 1e-15);
    EXPECT_NEAR(other.limits.upper, c.limits.upper, 1e-15);
  }
}

TEST_P(SimulatorFiles, ConstantForcesSurviveAnMjcfRoundTrip) {
  ModelDescription d = plausible_model(read_model(GetParam()), 3).arm.description();
  d.effects.clear();
  for (std::size_t i = 0; i < d.coordinates.size(); ++i) {
    EffectTerm term;
    term.effect = "torque_offset";
    term.axis.coefficients = VectorXd::Unit(static_cast<Eigen::Index>(d.coordinates.size()), static_cast<Eigen::Index>(i));
    term.values["offset"] = 0.4 - 0.3 * static_cast<double>(i);
    d.effects.push_back(term);
  }
  const Model arm(std::move(d));
  expect_same_torques(arm, read_model(folder_.write("arm.mjcf", to_mjcf(arm))));
}

TEST_P(SimulatorFiles, SdfIsReadBackAsTheArm) {
  ModelDescription d = with_effects(plausible_model(read_model(GetParam()), 3).arm, {"viscous_friction", "coulomb_friction"}).description();
  d.gravity = {0, 0, -9.81};  // which SDFormat keeps in the world
  const Model arm(std::move(d));
  const Model read = read_model(folder_.write("arm.sdf", to_sdf(arm)));
  expect_same_frames(arm, read);
  expect_same_torques(arm, read);
}

INSTANTIATE_TEST_SUITE_P(Robots, SimulatorFiles,
                         testing::Values("planar-2r", "psm-3dof", "psm-wrist", "mtm", "ur10e", "kuka-lwr4", "scara", "elbow-6r"),
                         sample_arm_name);

const EffectTerm* term_of(const Model& arm, const std::string& effect, int coordinate) {
  for (const EffectTerm& term : arm.effects()) {
    if (term.effect == effect && main_coordinate(term.axis).value == coordinate) return &term;
  }
  return nullptr;
}

// Simulators refuse negative damping, as our own readers do; an unconstrained fit can find it.
TEST(ExportedEffects, NegativeDampingIsLeftOutAndReported) {
  ModelDescription d = read_model("planar-2r").description();
  for (EffectTerm& term : d.effects) {
    if (term.axis.coefficients[1] == 1.0 && term.effect == "viscous_friction") term.values["coefficient"] = -0.4;
  }
  const Model arm(std::move(d));
  const TemporaryFolder folder;
  for (const auto& [name, content] : std::map<std::string, std::string>{{"arm.urdf", to_urdf(arm)}, {"arm.xml", to_mjcf(arm)}, {"arm.sdf", to_sdf(arm)}}) {
    EXPECT_NE(content.find("left out: viscous_friction on "), std::string::npos) << name;
    EXPECT_EQ(read_model(folder.write(name, content)).effects().size(), 3U) << name;
  }
}

// A link called as a joint is gets another name in SDFormat, which no other link has.
TEST(ExportedNames, OfSdfLinksAreUnique) {
  ModelDescription d = read_model("planar-2r").description();
  d.frames[0].name = "shoulder";
  d.frames[1].name = "shoulder_link";
  const Model arm(std::move(d));
  const TemporaryFolder folder;
  const Model read = read_model(folder.write("arm.sdf", to_sdf(arm)));
  EXPECT_EQ(read.joints(), 2);
  EXPECT_TRUE(read.find_frame("shoulder_link"));
}

TEST(StrangersMjcf, IsReadWithItsClassesUnitsAndActuators) {
  const TemporaryFolder folder;
  const Model arm = read_model(folder.write("stranger.xml", kStrangerMjcf));
  EXPECT_EQ(arm.name(), "stranger");
  EXPECT_EQ(arm.description().values, RobotValues::kPrior);
  EXPECT_TRUE(near(arm.gravity(), Eigen::Vector3d(0.5, 0, -9.7), 0.0));
  ASSERT_EQ(arm.joints(), 4);
  const char* const names[] = {"yaw", "pitch", "elbow", "reach"};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(arm.coordinates()[i].name, names[i]);
  EXPECT_NEAR(arm.coordinates()[2].limits.lower, -M_PI / 2, 1e-15);  // of the class above its own
  EXPECT_EQ(arm.coordinates()[3].limits.upper, 0.2);                 // metres in spite of degrees
  EXPECT_EQ(arm.coordinates()[0].limits.effort, 40.0);               // gear 20, control 2
  EXPECT_EQ(arm.coordinates()[1].limits.effort, 12.0);               // of a servo
  EXPECT_TRUE(std::isinf(arm.coordinates()[2].limits.effort));
  EXPECT_EQ(arm.coordinates()[3].limits.effort, 6.0);
  EXPECT_EQ(term_of(arm, "torque_offset", 3)->values.at("offset"), -3.0);
  EXPECT_EQ(term_of(arm, "viscous_friction", 2)->values.at("coefficient"), 0.05);  // class weak
  EXPECT_EQ(term_of(arm, "coulomb_friction", 1)->values.at("level"), 0.4);         // class strong
  EXPECT_EQ(term_of(arm, "coulomb_friction", 2), nullptr);
  EXPECT_EQ(term_of(arm, "rotor_inertia", 2)->values.at("inertia"), 0.01);  // class main
  EXPECT_NEAR(term_of(arm, "joint_spring", 1)->axis.offset, -20 * M_PI / 180, 1e-15);
  const Frame& finger = arm.frames()[arm.find_frame("finger")->value];
  EXPECT_EQ(finger.variable.coefficients[3], -0.5);
  EXPECT_NEAR(finger.variable.offset, 0.02, 1e-15);  // 0.01 + 0.02 - 0.5 reach, less its reference
  EXPECT_TRUE(arm.find_frame("mark"));
}

// A joint's effort limit is the sum of what its actuators can give; one without a limit leaves none.
TEST(MjcfActuators, SetTheEffortLimitOfTheirJoint) {
  const TemporaryFolder folder;
  const auto limit = [&](const std::string& actuators) {
    const std::string arm = "<mujoco model=\"a\"><worldbody><body name=\"b\"><joint name=\"j\" type=\"hinge\"/>"
                            "<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/></body></worldbody><actuator>";
    return read_model(folder.write("arm.xml", arm + actuators + "</actuator></mujoco>")).coordinates()[0].limits.effort;
  };
  EXPECT_EQ(limit(R"(<motor joint="j" ctrlrange="-3 2"/>)"), 3.0);
  EXPECT_EQ(limit(R"(<motor joint="j" ctrlrange="-2 3" gear="-10"/>)"), 30.0);
  EXPECT_EQ(limit(R"(<motor joint="j" ctrlrange="-2 3" forcerange="-1 2.5"/>)"), 2.5);
  EXPECT_EQ(limit(R"(<motor joint="j" ctrlrange="-2 3" forcerange="-4 1"/>)"), 3.0);
  EXPECT_EQ(limit(R"(<general joint="j" ctrlrange="-2 3" gainprm="-5"/>)"), 15.0);
  EXPECT_EQ(limit(R"(<motor joint="j" ctrlrange="-2 3"/><motor joint="j" ctrlrange="-1 1"/>)"), 4.0);
  EXPECT_EQ(limit(R"(<motor joint="j" ctrlrange="-2 3"/><motor joint="j"/>)"), kInfinity);
  EXPECT_EQ(limit(R"(<motor joint="j" ctrlrange="-2 3" ctrllimited="false"/>)"), kInfinity);
  EXPECT_EQ(limit(R"(<position joint="j" kp="100" ctrlrange="-2 3"/>)"), kInfinity);  // its control is a position
  EXPECT_EQ(limit(R"(<position joint="j" kp="100" ctrlrange="-2 3" forcerange="-7 7"/>)"), 7.0);
  EXPECT_EQ(limit(R"(<general joint="j" ctrlrange="-2 3" biastype="affine" biasprm="0 -100 0"/>)"), kInfinity);
}

TEST(MjcfGeoms, OnlyGeomsOfTheInertiaGroupsHaveMass) {
  const TemporaryFolder folder;
  const auto mass = [&](const std::string& compiler) {
    const std::string arm = "<worldbody><body name=\"b\"><joint name=\"j\" type=\"hinge\"/><geom size=\"0.1\" mass=\"1\"/>"
                            "<geom size=\"0.1\" mass=\"2\" group=\"2\"/><geom size=\"0.1\" mass=\"4\" group=\"3\"/></body></worldbody>";
    return (*read_model(folder.write("arm.xml", "<mujoco model=\"a\">" + compiler + arm + "</mujoco>")).inertial_values())[0];
  };
  EXPECT_EQ(mass(""), 7.0);
  EXPECT_EQ(mass(R"(<compiler inertiagrouprange="0 2"/>)"), 3.0);
  EXPECT_EQ(mass(R"(<compiler inertiagrouprange="2 2"/>)"), 2.0);
  EXPECT_EQ(mass(R"(<compiler inertiagrouprange="3 5"/>)"), 4.0);
}

TEST(StrangersMjcf, AFollowerIsPlacedRelativeToItsReference) {
  const TemporaryFolder folder;
  const Model arm = read_model(folder.write("stranger.xml", kStrangerMjcf));
  const VectorXd zero = VectorXd::Zero(4);
  const Eigen::Isometry3d T = frame_pose(arm, zero, *arm.find_frame("slider"));
  // At reach 0 the follower reads 0.01 + 0.02, which is 0.02 beyond its reference.
  const Eigen::Vector3d expected = T * Eigen::Vector3d(0, 0.02, 0.1) +
                                   T.linear() * Eigen::Quaterniond(0.7, 0, 0.7, 0.1).normalized().toRotationMatrix() * Eigen::Vector3d(0, 0.02, 0);
  EXPECT_TRUE(near(Eigen::Vector3d(frame_pose(arm, zero, *arm.find_frame("finger")).translation()), expected, 1e-14));
}

TEST(StrangersSdf, IsReadWithItsRelativePoses) {
  const TemporaryFolder folder;
  const Model arm = read_model(folder.write("stranger.sdf", kStrangerSdf));
  ASSERT_EQ(arm.joints(), 3);
  EXPECT_EQ(arm.name(), "stranger");
  EXPECT_TRUE(near(arm.gravity(), Eigen::Vector3d(0, 0.3, -9.7), 0.0));
  EXPECT_EQ(arm.coordinates()[0].limits.effort, 40.0);
  EXPECT_EQ(arm.coordinates()[0].limits.lower, -1.5);
  EXPECT_TRUE(std::isinf(arm.coordinates()[1].limits.upper));
  EXPECT_TRUE(arm.coordinates()[1].prismatic);
  EXPECT_TRUE(std::isinf(arm.coordinates()[1].limits.effort));
  EXPECT_EQ(term_of(arm, "viscous_friction", 0)->values.at("coefficient"), 0.3);
  EXPECT_EQ(term_of(arm, "coulomb_friction", 0)->values.at("level"), 0.7);
  EXPECT_EQ(term_of(arm, "joint_spring", 0)->axis.offset, -0.2);
  const Frame& tool = arm.frames()[arm.find_frame("tool")->value];
  ASSERT_TRUE(tool.body.has_value());  // SDFormat's own values
  EXPECT_EQ((*tool.body->phi)[0], 1.0);
  // base: model, mount and base one after the other, with Rz Ry Rx of roll, pitch and yaw.
  const auto turn = [](double a, const Eigen::Vector3d& u) { return Eigen::AngleAxisd(a, u).toRotationMatrix(); };
  const Eigen::Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  Eigen::Isometry3d T = Eigen::Translation3d(0.1, 0.2, 0.3) * Eigen::Isometry3d(turn(0.3, z) * turn(0.2, y) * turn(0.1, x));
  T = T * Eigen::Translation3d(0, 0, 0.1) * Eigen::Isometry3d(turn(0.4, z)) * Eigen::Translation3d(0, 0, 0.05);
  const double q0 = 0.6;
  const Eigen::Vector3d q(q0, -0.1, 0.4);
  EXPECT_TRUE(near(frame_pose(arm, q, *arm.find_frame("base")).matrix(), T.matrix(), 1e-14));
  // upper: the joint's frame, a turn about an axis that is given in `mount`, the link in the joint's frame.
  const Eigen::Isometry3d joint = Eigen::Translation3d(0.1, 0, 0.2) * Eigen::Isometry3d(turn(0.3, x));
  const Eigen::Vector3d axis = turn(-0.3, x) * Eigen::Vector3d(0, 1, 0.2).normalized();
  T = T * joint * Eigen::Isometry3d(turn(q0, axis)) * Eigen::Translation3d(0.02, 0.03, 0) * Eigen::Isometry3d(turn(0.5, z));
  EXPECT_TRUE(near(frame_pose(arm, q, *arm.find_frame("upper")).matrix(), T.matrix(), 1e-14));
  // fore: slides along z of a frame that is placed in it.
  const Eigen::Isometry3d fore = Eigen::Translation3d(0.3, 0, 0) * Eigen::Isometry3d(turn(M_PI / 9, z) * turn(M_PI / 2, x));
  T = T * fore * Eigen::Translation3d(-0.1 * (turn(0.2, y) * z));
  EXPECT_TRUE(near(frame_pose(arm, q, *arm.find_frame("fore")).matrix(), T.matrix(), 1e-14));
  T = T * Eigen::Translation3d(0, 0, 0.1) * Eigen::Isometry3d(turn(M_PI / 2 + 0.4, z)) * Eigen::Translation3d(0, 0, 0.05);
  EXPECT_TRUE(near(frame_pose(arm, q, *arm.find_frame("tool")).matrix(), T.matrix(), 1e-14));
}

// ---- Bad files: one line with file, line, column, found and expected.

class BadFile : public testing::Test {
 protected:
  std::string error_of(const char* file, std::string content, const std::string& old_text, const std::string& new_text) {
    const std::size_t at = content.find(old_text);
    EXPECT_NE(at, std::string::npos) << old_text;
    content.replace(at, old_text.size(), new_text);
    const std::string path = folder_.write(file, content);
    try {
      read_model(path);
    } catch (const InvalidInput& error) {
      const std::string message = error.what();
      EXPECT_EQ(message.find(path + ":"), 0U) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos);
      EXPECT_NE(message.find(", expected "), std::string::npos) << message;
      EXPECT_TRUE(std::isdigit(static_cast<unsigned char>(message[path.size() + 1]))) << message;
      return message.substr(path.size() + 1);
    }
    return "no error";
  }

  TemporaryFolder folder_;
};

TEST_F(BadFile, UnsupportedMjcfIsRefusedWithItsPlace) {
  const auto error = [&](const char* old_text, const char* new_text) { return error_of("arm.xml", kStrangerMjcf, old_text, new_text); };
  EXPECT_EQ(error("<site name=\"mark\"", "<joint type=\"ball\" name=\"x\" range=\"1 2\""), "23:9: found a joint of type 'ball', expected hinge or slide.");
  EXPECT_EQ(error("<geom type=\"box\" size=\"0.1 0.1 0.1\"/>", "<freejoint/>"), "18:7: found a body that moves freely, expected arms on a fixed base.");
  EXPECT_EQ(error("pos=\"0.05 0 0.1\"", "pos=\"0.05 0\""), "22:9: found pos with 2 numbers, expected 3.");
  EXPECT_EQ(error("mass=\"2.5\"", "mass=\"heavy\""), "22:9: found mass 'heavy', expected finite numbers.");
  EXPECT_EQ(error("mass=\"2.5\"", "mass=\"nan\""), "22:9: found mass 'nan', expected finite numbers.");
  EXPECT_EQ(error("mass=\"2.5\"", "mass=\"-1\""), "22:9: found a mass of -1 kg, expected one that is not negative.");
  EXPECT_EQ(error("0.03 0.02 0.025", "-0.03 0.02 0.025"), "no error");  // a body that cannot be is a remark
  EXPECT_EQ(error("axis=\"0 0 2\"", "axis=\"0 0 0\""), "20:9: found no direction of the joint's axis, expected one.");
  EXPECT_EQ(error("range=\"-0.1 0.2\"", "range=\"0.2 0.1\""), "29:13: found the range 0.2 0.1, expected lower < upper.");
  EXPECT_EQ(error("childclass=\"strong\"", "childclass=\"stronk\"").find("19:7: found the class 'stronk', expected"), std::string::npos);
  EXPECT_EQ(error("class=\"weak\"/>", "class=\"week\"/>"), "25:11: found the class 'week', expected one that <default> defines.");
  EXPECT_EQ(error("polycoef=\"0.02 -0.5 0 0 0\"", "polycoef=\"0 1 0.3 0 0\""), "42:13: found a coupling that is not linear, expected polycoef with two numbers.");
  EXPECT_EQ(error("joint2=\"reach\"", "joint2=\"rich\""), "42:13: found joint2 'rich', expected the name of a hinge or slide.");
  EXPECT_EQ(error("joint2=\"reach\"", "joint2=\"follower\""), "34:15: found the joint 'follower' in a cycle of joints that follow each other, expected one that follows none in the end.");
  EXPECT_EQ(error("<equality>", "<equality><weld body1=\"fore\"/>"), "42:13: found an equality of kind 'weld', which closes a chain, expected chains that end, and couplings of joints.");
  EXPECT_EQ(error("<worldbody>", "<worldbody><include file=\"gripper.xml\"/>"), "15:14: found <include> of 'gripper.xml', expected one file with all of the arm (MuJoCo writes one: mj_saveLastXML).");
  EXPECT_EQ(error("<geom type=\"ellipsoid\"", "<geom type=\"mesh\" mesh=\"hand\""), "31:13: found a body without <inertial>, whose inertia MuJoCo infers from a mesh, expected <inertial> in its body (MuJoCo writes one: mj_saveLastXML).");
  EXPECT_EQ(error("size=\"0.02 0.06\"", "size=\"0.02\""), "30:13: found a cylinder without its sizes, expected 2 numbers above zero.");
  EXPECT_EQ(error("<option ", "<option density=\"1.2\" "), "3:3: found a medium (density 1.2), expected none: its drag is not known here.");
  EXPECT_EQ(error("<compiler ", "<compiler settotalmass=\"9\" "), "2:3: found the compiler's settotalmass, which changes bodies, expected bodies as they are.");
  EXPECT_EQ(error("eulerseq=\"XYz\"", "eulerseq=\"abc\""), "2:3: found eulerseq 'abc', expected three letters of x, y, z, X, Y, Z.");
  EXPECT_EQ(error("<body name=\"fore\"", "<body name=\"fore\" gravcomp=\"1\""), "24:9: found gravity compensation of a body (gravcomp), expected none: motors carry the weight.");
  EXPECT_EQ(error("<joint joint=\"yaw\" coef=\"1\"/>", "<joint joint=\"yaw\" coef=\"one\"/>"), "43:58: found coef 'one', expected a number.");
  EXPECT_EQ(error("frictionloss=\"0.4\"", "frictionloss=\"-0.4\""), "20:9: found a frictionloss of -0.4, expected one that is not negative.");
}

TEST_F(BadFile, UnsupportedSdfIsRefusedWithItsPlace) {
  const auto error = [&](const char* old_text, const char* new_text) { return error_of("arm.sdf", kStrangerSdf, old_text, new_text); };
  EXPECT_EQ(error("type=\"prismatic\"", "type=\"screw\""), "29:7: found a joint of type 'screw', expected revolute, continuous, prismatic or fixed.");
  EXPECT_EQ(error("<child>fore</child>", "<child>for</child>"), "29:7: found the name 'for', expected that of a link of this model.");
  EXPECT_EQ(error("<child>fore</child>", "<child>upper</child>"), "29:7: found the joint 'slide', a second one above the link 'upper', expected no closed chain.");
  EXPECT_EQ(error("<mass>2</mass>", "<mass>two</mass>"), "22:50: found mass 'two', expected finite numbers.");
  EXPECT_EQ(error("<pose relative_to=\"swing\">", "<pose relative_to=\"sling\">"), "20:7: found the name 'sling', expected that of a link, joint or frame of this model.");
  EXPECT_EQ(error("<link name=\"tool\"", "<link name=\"fore\""), "40:7: found a second part 'fore', expected names that are unique.");
  EXPECT_EQ(error("0.02 0.03 0 0 0 0.5", "0.02 0.03 0 0 0"), "21:9: found pose with 5 numbers, expected 6.");
  EXPECT_EQ(error("<link name=\"base\">", "<include><uri>model://base</uri></include><link name=\"base\">"), "9:7: found <include> in a model, expected one model with all of its links (gz sdf -p prints one).");
  EXPECT_EQ(error("<frame name=\"mount\"><pose>", "<frame name=\"mount\"><pose relative_to=\"base\">"), "8:7: found the pose of 'mount' in a cycle, expected one that ends at the model.");
  EXPECT_EQ(error("<xyz expressed_in=\"mount\">0 1 0.2</xyz>", "<xyz>0 0 0</xyz>"), "11:7: found no direction of the joint's axis, expected one.");
  EXPECT_EQ(error("<lower>-1.5</lower>", "<lower>2.5</lower>"), "16:11: found limits [2.5, 2], expected lower < upper.");
  EXPECT_EQ(error("<parent>base</parent>", "<parent>tool</parent>").find("no error"), std::string::npos);
}

TEST_F(BadFile, DamagedSimulatorFilesAreRefusedAndNeverCrash) {
  for (const char* file : {"arm.xml", "arm.sdf"}) {
    const std::string whole = std::string(file) == "arm.xml" ? kStrangerMjcf : kStrangerSdf;
    int refused = 0, trials = 0;
    for (std::size_t at = 0; at < whole.size(); at += 13) {
      for (const char* inserted : {"", "<", "\"", "9e999", "-"}) {
        std::string content = whole;
        *inserted == 0 ? content.resize(at) : content.replace(at, 1, inserted).shrink_to_fit();
        const std::string path = folder_.write(file, content);
        ++trials;
        try {
          read_model(path);
        } catch (const InvalidInput& error) {
          ++refused;
          const std::string message = error.what();
          EXPECT_EQ(message.find(path), 0U) << message;
          EXPECT_EQ(message.find('\n'), std::string::npos) << message;
        }
      }
    }
    EXPECT_GT(refused, trials / 2);
    std::string deep(200000, ' ');
    deep = std::string(file) == "arm.xml" ? "<mujoco><worldbody>" : "<sdf><model>";
    for (int k = 0; k < 100000; ++k) deep += "<body>";
    EXPECT_THROW(read_model(folder_.write(file, deep)), InvalidInput);
    for (int k = 0; k < 100000; ++k) deep += "</body>";
    deep += std::string(file) == "arm.xml" ? "</worldbody></mujoco>" : "</model></sdf>";
    EXPECT_THROW(read_model(folder_.write(file, deep)), InvalidInput);
  }
}

// Times grow with the third power of the joints, so that their number has a limit, which is told before anything grows.
TEST(RobotFormats, ArmsOfThousandsOfJointsAreRefused) {
  const TemporaryFolder folder;
  const auto file = [&](const std::string& name, int joints) {
    std::string urdf = "<robot name=\"a\"><link name=\"l\"/>", mjcf = "<mujoco model=\"a\"><worldbody>", sdf = "<sdf version=\"1.7\"><model name=\"a\"><link name=\"l\"/>";
    std::string yaml = "veridyn: 1\nname: a\nconvention: standard\ncoordinates:\n", frames = "frames:\n";
    for (int k = 0; k < joints; ++k) {
      const std::string n = std::to_string(k);
      urdf += "<link name=\"l" + n + "\"/><joint name=\"j" + n + "\" type=\"continuous\"><parent link=\"l\"/><child link=\"l" + n + "\"/></joint>";
      mjcf += "<body name=\"b" + n + "\"><joint name=\"j" + n + "\" type=\"hinge\"/><geom size=\"1\" mass=\"1\"/></body>";
      sdf += "<link name=\"l" + n + "\"/><joint name=\"j" + n + "\" type=\"revolute\"><parent>l</parent><child>l" + n + "</child><axis><xyz>0 0 1</xyz></axis></joint>";
      yaml += "  - {name: j" + n + "}\n";
      frames += "  - {name: f" + n + ", parent: world, dh: [1, 0, 0, 0], revolute: {j" + n + ": 1}}\n";
    }
    const std::map<std::string, std::string> contents = {
        {"a.urdf", urdf + "</robot>"}, {"a.xml", mjcf + "</worldbody></mujoco>"}, {"a.sdf", sdf + "</model></sdf>"}, {"a.yaml", yaml + frames}};
    return folder.write(name, contents.at(name));
  };
  for (const char* name : {"a.urdf", "a.xml", "a.sdf", "a.yaml"}) {
    EXPECT_EQ(read_model(file(name, 3)).joints(), 3) << name;
    const std::string said = refusal([&] { read_model(file(name, 5000)); });
    EXPECT_NE(said.find("expected at most 500."), std::string::npos) << said;
  }
}

// An ending .xml says nothing: the root element does.
TEST(RobotFormats, AreRecognisedByTheirRootElement) {
  const TemporaryFolder folder;
  EXPECT_EQ(read_model(folder.write("a.xml", kStrangerMjcf)).name(), "stranger");
  EXPECT_EQ(read_model(folder.write("b.xml", kStrangerSdf)).joints(), 3);
  EXPECT_THROW(read_model(folder.write("c.mjcf", kStrangerSdf)), InvalidInput);
}

}  // namespace
}  // namespace veridyn
