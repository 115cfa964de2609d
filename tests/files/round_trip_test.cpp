#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "support/near.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "files/output_file.hpp"
#include "model/joint_placement.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/files/urdf.hpp"

namespace veridyn {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kFileRounding = 1e-15;  // what a file may lose of a number
constexpr double kPoseRounding = 1e-12;

// The robots of data/robots/ and the sample arms of the tests.
Model robot(const std::string& name) {
  const auto sample = sample_arms().find(name);
  return sample == sample_arms().end() ? read_model(name) : sample->second;
}

std::vector<std::string> all_robots() {
  std::vector<std::string> names = robot_names();
  for (const std::string& name : sample_arm_names()) names.push_back(name);
  return names;
}

class OnEveryRobot : public testing::TestWithParam<std::string> {
 protected:
  static Model arm() { return robot(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(Robot, OnEveryRobot, testing::ValuesIn(all_robots()), sample_arm_name);

void expect_same_number(double a, double b) {
  if (std::isfinite(b)) {
    EXPECT_NEAR(a, b, kFileRounding * (1.0 + std::abs(b)));
  } else {
    EXPECT_EQ(a, b);
  }
}

void expect_same_limits(const Limits& a, const Limits& b) {
  expect_same_number(a.lower, b.lower);
  expect_same_number(a.upper, b.upper);
  expect_same_number(a.velocity, b.velocity);
  expect_same_number(a.acceleration, b.acceleration);
  expect_same_number(a.effort, b.effort);
}

void expect_same_parameters(const std::optional<InertialParameters>& a,
                            const std::optional<InertialParameters>& b) {
  ASSERT_EQ(a.has_value(), b.has_value());
  for (int i = 0; a && i < kBodyParameters; ++i) expect_same_number((*a)[i], (*b)[i]);
}

void expect_same_frame(const Frame& a, const Frame& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.parent, b.parent);
  EXPECT_EQ(a.type, b.type);
  EXPECT_TRUE(near(a.variable.coefficients, b.variable.coefficients, kFileRounding));
  expect_same_number(a.variable.offset, b.variable.offset);
  EXPECT_EQ(a.dh.has_value(), b.dh.has_value());
  ASSERT_EQ(a.body.has_value(), b.body.has_value());
  if (!a.body) return;
  expect_same_parameters(a.body->phi, b.body->phi);
  expect_same_parameters(a.body->std_phi, b.body->std_phi);
  EXPECT_EQ(a.body->fixed, b.body->fixed);
  EXPECT_EQ(a.body->box.mass_max, b.body->box.mass_max);
  EXPECT_EQ(a.body->box.com_reach, b.body->box.com_reach);
}

void expect_same_axis(const Axis& a, const Axis& b) {
  EXPECT_TRUE(near(a.coefficients, b.coefficients, kFileRounding));
  expect_same_number(a.offset, b.offset);
}

void expect_same_effect(const EffectTerm& a, const EffectTerm& b) {
  EXPECT_EQ(a.effect, b.effect);
  expect_same_axis(a.axis, b.axis);
  ASSERT_EQ(a.from.has_value(), b.from.has_value());
  if (a.from) expect_same_axis(*a.from, *b.from);
  EXPECT_EQ(a.frame, b.frame);
  EXPECT_EQ(a.values, b.values);
  EXPECT_EQ(a.deviations, b.deviations);
}

void expect_same_identified(const IdentifiedBase& a, const IdentifiedBase& b) {
  EXPECT_EQ(a.recordings, b.recordings);
  EXPECT_EQ(a.clusters, b.clusters);
  EXPECT_EQ(a.error, b.error);
  EXPECT_EQ(a.motion, b.motion);
  ASSERT_EQ(a.parameters.size(), b.parameters.size());
  for (std::size_t j = 0; j < a.parameters.size(); ++j) {
    EXPECT_EQ(a.parameters[j].name, b.parameters[j].name);
    EXPECT_EQ(a.parameters[j].unit, b.parameters[j].unit);
    EXPECT_EQ(a.parameters[j].combination, b.parameters[j].combination);
    EXPECT_EQ(a.parameters[j].value, b.parameters[j].value);
    EXPECT_EQ(a.parameters[j].free, b.parameters[j].free);
    EXPECT_EQ(a.parameters[j].scatter, b.parameters[j].scatter);
  }
}

void expect_same_description(const Model& a, const Model& b) {
  EXPECT_EQ(a.name(), b.name());
  EXPECT_EQ(a.description().source, b.description().source);
  EXPECT_EQ(a.gravity(), b.gravity());
  EXPECT_EQ(a.description().constants, b.description().constants);
  EXPECT_EQ(a.description().box.mass_max, b.description().box.mass_max);
  EXPECT_EQ(a.description().box.com_reach, b.description().box.com_reach);
  ASSERT_EQ(a.joints(), b.joints());
  for (std::size_t i = 0; i < a.coordinates().size(); ++i) {
    EXPECT_EQ(a.coordinates()[i].name, b.coordinates()[i].name);
    EXPECT_EQ(a.coordinates()[i].drive_gain, b.coordinates()[i].drive_gain);
    EXPECT_EQ(a.coordinates()[i].drive_gain_deviation, b.coordinates()[i].drive_gain_deviation);
    expect_same_limits(a.coordinates()[i].limits, b.coordinates()[i].limits);
  }
  ASSERT_EQ(a.frames().size(), b.frames().size());
  for (std::size_t k = 0; k < a.frames().size(); ++k)
    expect_same_frame(a.frames()[k], b.frames()[k]);
  ASSERT_EQ(a.effects().size(), b.effects().size());
  for (std::size_t e = 0; e < a.effects().size(); ++e)
    expect_same_effect(a.effects()[e], b.effects()[e]);
  const std::optional<IdentifiedBase>& identified = a.description().identified;
  ASSERT_EQ(identified.has_value(), b.description().identified.has_value());
  if (identified) expect_same_identified(*identified, *b.description().identified);
}

// Every frame of b that a knows stands where it stands in a.
void expect_same_poses(const Model& a, const Model& b) {
  Random random(21);
  for (int trial = 0; trial < 10; ++trial) {
    const VectorXd q = random.vector(a.joints(), -2, 2);
    for (const Frame& frame : a.frames()) {
      SCOPED_TRACE(frame.name);
      ASSERT_TRUE(b.find_frame(frame.name));
      const Eigen::Matrix4d in_a = frame_pose(a, q, *a.find_frame(frame.name)).matrix();
      EXPECT_TRUE(near(in_a, frame_pose(b, q, *b.find_frame(frame.name)).matrix(), kPoseRounding));
    }
  }
}

TEST_P(OnEveryRobot, YamlRoundTripKeepsDescriptionAndPoses) {
  const Model before = arm();
  const Model after = read_yaml(to_yaml(before), "copy.yaml");
  expect_same_description(after, before);
  expect_same_poses(before, after);
}

// Calibration and diagnosis change numbers of a model that came from a file: what counts is the
// model, not the row or the arithmetic that it came from.
TEST(RobotFiles, YamlRoundTripKeepsChangedFrames) {
  for (const std::string& name : robot_names()) {
    ModelDescription d = read_model(name).description();
    Random random(32);
    for (Frame& frame : d.frames) {
      if (frame.type != JointType::kFixed) frame.variable.offset += random.in(-0.1, 0.1);
      if (random.in(0, 1) < 0.3) frame.A = random.pose(0.1) * frame.A;
    }
    const Model changed(d);
    expect_same_poses(changed, read_yaml(to_yaml(changed), "copy.yaml"));
  }
}

// (The poses of the sample arms, which have no DH rows, are rounded again each time.)
TEST(RobotFiles, AreWrittenIdenticallyEachTime) {
  ASSERT_FALSE(robot_names().empty());
  for (const std::string& name : robot_names()) {
    const std::string written = to_yaml(read_model(name));
    EXPECT_EQ(to_yaml(read_yaml(written, "copy.yaml")), written);
  }
}

// A URDF may call a joint what YAML takes for nothing, a truth value or a number: the file is read
// back with the same names, and other readers of YAML find texts as well.
TEST(RobotFiles, NamesThatYamlWouldMisreadAreQuoted) {
  for (const std::string& name : {std::string("null"), std::string("Yes"), std::string("1e5"),
                                  std::string("0x10"), std::string("1_000"), std::string("~"),
                                  std::string("a: b # c"), std::string(300, 'n')}) {
    SCOPED_TRACE(name);
    const std::string quoted = "\"" + name + "\"";
    const Model before = read_yaml("veridyn: 1\nname: " + quoted + "\ncoordinates: [{name: " + quoted +
                                       "}]\nframes: [{name: " + quoted + ", parent: world, " +
                                       "origin: {xyz: [0, 0, 1]}, revolute: {" + quoted + ": 1}}]\n",
                                   "arm.yaml");
    const std::string text = to_yaml(before);
    const Model after = read_yaml(text, "copy.yaml");
    expect_same_description(after, before);
    ASSERT_EQ(after.coordinates().size(), 1U);
    EXPECT_EQ(after.coordinates()[0].name, name);
    EXPECT_NE(text.find("name: " + (name.size() < 300 ? quoted : name)), std::string::npos);
  }
}

// Names with everything that could confuse YAML.
IdentifiedBase random_identified(int joints, Random& random) {
  IdentifiedBase out;
  out.recordings = {"one.csv", "with space, comma: and #.csv", "yes"};
  out.clusters = 4;
  out.error = random.vector(joints, 0, 1);
  out.motion = MatrixXd(4, joints);
  for (double& x : out.motion.reshaped()) x = random.in(0, 1);
  for (const std::string name :
       {"m_tool", "viscous_friction(1.2178 yaw1 - 0.8306 pitch).coefficient",
        "presliding_hysteresis(yaw, distance 0.005).level"}) {
    out.parameters.push_back({name,
                              "kg m^2",
                              {{name, 1.0}, {"other", random.in(-1, 1)}},
                              random.in(-1, 1),
                              random.in(-1, 1),
                              random.vector(4, -1, 1)});
  }
  return out;
}

Model identified(ModelDescription d) {
  Random random(31);
  d.identified = random_identified(static_cast<int>(d.coordinates.size()), random);
  for (Frame& frame : d.frames) {
    if (!frame.body) continue;
    frame.body->phi = random.body();
    frame.body->std_phi = InertialParameters(random.vector(kBodyParameters, 0, 0.1));
    frame.body->fixed = random.in(0, 1) < 0.3;
    frame.body->box = {random.in(1, 2), random.in(0, 1)};
  }
  for (EffectTerm& term : d.effects) {
    term.axis.offset = term.effect == "torque_offset" ? 0.0 : random.in(-1, 1);
    term.values["offset"] = random.in(-1, 1);  // called like a key of its own
    term.deviations["offset"] = random.in(0, 1);
  }
  if (!d.effects.empty()) d.effects.front().from = Axis{d.effects.back().axis.coefficients, 0.3};
  for (Coordinate& c : d.coordinates) {
    c.drive_gain = random.in(-9, 9);
    c.drive_gain_deviation = random.in(0, 1);
    c.limits.lower = -kInfinity;
    c.limits.effort = random.in(1, 2);
  }
  return Model(d);
}

TEST_P(OnEveryRobot, YamlKeepsIdentifiedValuesAndTheirDeviations) {
  const Model before = identified(arm().description());
  expect_same_description(read_yaml(to_yaml(before), "copy.yaml"), before);
}

Model through_urdf(const Model& arm) {
  const auto path =
      std::filesystem::temp_directory_path() / ("veridyn_round_trip_" + arm.name() + ".urdf");
  std::ofstream(path) << to_urdf(arm);
  Model read = read_urdf(path.string());
  std::filesystem::remove(path);
  return read;
}

TEST_P(OnEveryRobot, UrdfKeepsPosesOfAllFrames) {
  const Model before = arm();
  const Model after = through_urdf(before);
  ASSERT_EQ(after.joints(), before.joints());
  for (std::size_t i = 0; i < before.coordinates().size(); ++i) {
    EXPECT_EQ(after.coordinates()[i].name, before.coordinates()[i].name);
    EXPECT_EQ(after.coordinates()[i].prismatic, before.coordinates()[i].prismatic);
  }
  expect_same_poses(before, after);
  // ... and so does YAML after URDF, whose frames come without DH rows.
  expect_same_poses(before, read_yaml(to_yaml(after), "copy.yaml"));
}

TEST_P(OnEveryRobot, UrdfKeepsInertias) {
  const Model before = identified(arm().description());
  const Model after = through_urdf(before);
  for (const Frame& frame : before.frames()) {
    const auto& body = after.frames()[after.find_frame(frame.name)->value].body;
    ASSERT_EQ(body.has_value(), frame.body.has_value());
    if (!body) continue;
    EXPECT_TRUE(near(*body->phi, *frame.body->phi, kPoseRounding));
  }
}

TEST(JointPlacement, RollPitchYawRoundTripKeepsTheRotationEvenAtThePole) {
  Random random(41);
  for (int trial = 0; trial < 300; ++trial) {
    // Every third at or near the pole, where roll and yaw turn about one line.
    const double pole =
        trial % 3 == 0 ? (trial % 2 == 0 ? M_PI / 2 : -M_PI / 2 + 1e-9 * random.in(-1, 1)) : 0.0;
    const double pitch = trial % 3 == 0 ? pole : random.in(-4, 4);
    const Mat3d R = rotation_from_rpy({random.in(-4, 4), pitch, random.in(-4, 4)});
    const Mat3d back = rotation_from_rpy(rpy_from_rotation(R));
    const Mat3d error = transpose(R) * back;
    EXPECT_NEAR(error.row0.x + error.row1.y + error.row2.z, 3.0, 1e-14);
    EXPECT_NEAR(error.row0.y, 0.0, 3e-15);
    EXPECT_NEAR(error.row0.z, 0.0, 3e-15);
    EXPECT_NEAR(error.row1.z, 0.0, 3e-15);
  }
}

}  // namespace
}  // namespace veridyn
