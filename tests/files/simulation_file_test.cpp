#include "veridyn/files/simulation_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "support/near.hpp"
#include "support/stranger_files.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/joint_torques.hpp"

// The values of a model go back into the file of the simulation, and nothing else of it changes.

namespace veridyn {
namespace {

class SimulationFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string path = (std::filesystem::temp_directory_path() / "veridyn-simulation-file-XXXXXX").string();
    ASSERT_NE(mkdtemp(path.data()), nullptr);
    folder_ = path;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name) << content;
    return (folder_ / name).string();
  }

  std::filesystem::path folder_;
};

// Another mass, other friction, a rotor, a softer spring and a load on the last frame.
Model extended(const Model& arm, const std::string& frame) {
  ModelDescription d = arm.description();
  for (Frame& f : d.frames) {
    if (f.body && f.name == frame) *f.body->phi *= 1.3;
  }
  for (EffectTerm& term : d.effects) {
    if (term.axis.coefficients.cwiseAbs().sum() != 1.0) continue;
    if (term.effect == "viscous_friction" && term.axis.coefficients[0] == 1.0) term.values["coefficient"] = 0.9;
    if (term.effect == "coulomb_friction" && term.axis.coefficients[0] == 1.0) term.values["level"] = 0.25;
    if (term.effect == "joint_spring") {
      term.values["stiffness"] *= 0.5;
      term.axis.offset -= 0.1;
    }
  }
  Frame load;
  load.name = "load";
  load.parent = FrameIndex{static_cast<int>(d.frames.size()) - 1};
  load.A.p = {0.01, 0.02, 0.03};
  load.variable.coefficients = VectorXd::Zero(arm.joints());
  Body body;
  Eigen::Matrix<double, 6, 1> inertia;
  inertia << 1e-3, 0, 1e-3, 0, 0, 1e-3;
  body.phi = inertial_parameters(0.5, Eigen::Vector3d(0.01, 0, 0.05), inertia);
  load.body = body;
  d.frames.push_back(load);
  return Model(std::move(d));
}

void expect_same_torques(const Model& a, const Model& b) {
  ASSERT_EQ(a.joints(), b.joints());
  std::srand(8);
  for (int trial = 0; trial < 10; ++trial) {
    const VectorXd q = VectorXd::Random(a.joints()), dq = VectorXd::Random(a.joints()), ddq = VectorXd::Random(a.joints());
    const VectorXd tau = joint_torques(a, q, dq, ddq);
    EXPECT_TRUE(near(joint_torques(b, q, dq, ddq), tau, 1e-9 * (1.0 + tau.cwiseAbs().maxCoeff())));
  }
}

bool contains_text(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_F(SimulationFile, OnlyChangedValuesOfAnMjcfAreReplaced) {
  std::string content = kStrangerMjcf;
  content.insert(content.find("  <equality>"), "  <!-- a camera for the film -->\n  <sensor><jointpos joint=\"yaw\"/></sensor>\n");
  content.insert(content.find("stiffness=\"4\""), "springlength=\"0.1\" ");
  const std::string path = write("arm.xml", content);
  const Model before = read_model(path);
  const Model after = extended(before, "fore");
  const UpdatedFile updated = updated_mjcf(after, path);
  const Model read = read_model(write("new.xml", updated.xml));
  EXPECT_TRUE(read.find_frame("load"));
  expect_same_torques(after, read);
  for (const char* kept : {"<!-- a camera for the film -->", "<jointpos joint=\"yaw\" />", "class=\"weak\"", "kp=\"100\"", "fromto=\"0 0 0 0.3 0.05 0\"",
                           "fullinertia=\"0.03 0.02 0.025 0.001 0.002 -0.001\""})
    EXPECT_TRUE(contains_text(updated.xml, kept)) << kept;
  EXPECT_TRUE(std::count(updated.changed.begin(), updated.changed.end(), "inertial of fore") == 1);
  EXPECT_TRUE(std::count(updated.changed.begin(), updated.changed.end(), "inertial of upper") == 0);
  EXPECT_TRUE(updated.left_out.empty()) << updated.left_out.front();
}

// An equality called as a joint is, and a resting model with a link called as one of the arm's, stand before
// the arm: neither is taken for it.
TEST_F(SimulationFile, AmbiguousNamesReferToElementsOfTheArm) {
  std::string content = kStrangerMjcf;
  const std::string equality = "<equality><joint joint1";
  content.erase(content.find(equality), content.find("</equality>") + 11 - content.find(equality));
  content.insert(content.find("  <worldbody>"), "  <equality><joint name=\"pitch\" joint1=\"follower\" joint2=\"reach\" polycoef=\"0.02 -0.5 0 0 0\"/></equality>\n");
  const std::string mjcf = write("arm.xml", content);
  ModelDescription d = read_model(mjcf).description();
  for (EffectTerm& term : d.effects) {
    if (term.effect == "viscous_friction" && term.axis.coefficients[1] == 1.0) term.values["coefficient"] = 0.9;
  }
  const UpdatedFile updated = updated_mjcf(Model(d), mjcf);
  EXPECT_EQ(updated.changed, std::vector<std::string>{"damping of pitch"});
  expect_same_torques(Model(d), read_model(write("new.xml", updated.xml)));

  content = kStrangerSdf;
  content.replace(content.find("<link name=\"plane\""), 18, "<link name=\"upper\"");
  const std::string sdf = write("arm.sdf", content);
  const Model after = extended(read_model(sdf), "upper");
  expect_same_torques(after, read_model(write("new.sdf", updated_sdf(after, sdf).xml)));
}

// A load on a site, such as a flange, becomes a body of the body that carries the site.
TEST_F(SimulationFile, ALoadOnASiteIsAdded) {
  const std::string path = write("arm.xml", kStrangerMjcf);
  ModelDescription d = extended(read_model(path), "none").description();
  d.effects = read_model(path).effects();
  d.frames.back().parent = read_model(path).find_frame("mark");
  const Model after(std::move(d));
  const UpdatedFile updated = updated_mjcf(after, path);
  EXPECT_EQ(updated.changed, std::vector<std::string>{"a new body load"});
  EXPECT_TRUE(updated.left_out.empty());
  expect_same_torques(after, read_model(write("new.xml", updated.xml)));
}

// Without a change nothing is written: the file's own numbers stay.
TEST_F(SimulationFile, AnUnchangedModelChangesNoValue) {
  const std::string mjcf = write("arm.xml", kStrangerMjcf);
  const UpdatedFile a = updated_mjcf(read_model(mjcf), mjcf);
  EXPECT_TRUE(a.changed.empty()) << a.changed.front();
  EXPECT_FALSE(contains_text(a.xml, "diaginertia=\"0.0"));
  const std::string sdf = write("arm.sdf", kStrangerSdf);
  const UpdatedFile b = updated_sdf(read_model(sdf), sdf);
  EXPECT_TRUE(b.changed.empty()) << b.changed.front();
}

TEST_F(SimulationFile, OnlyChangedValuesOfAnSdfAreReplaced) {
  const std::string path = write("arm.sdf", kStrangerSdf);
  const Model after = extended(read_model(path), "upper");
  const UpdatedFile updated = updated_sdf(after, path);
  const Model read = read_model(write("new.sdf", updated.xml));
  EXPECT_TRUE(read.find_frame("load"));
  expect_same_torques(after, read);
  EXPECT_TRUE(contains_text(updated.xml, "<plane") || contains_text(updated.xml, "name=\"plane\""));
  EXPECT_TRUE(updated.left_out.empty()) << updated.left_out.front();
}

// What the format has no words for is named, in the result and in the file.
TEST_F(SimulationFile, UnrepresentedEffectsAreReported) {
  const std::string path = write("arm.xml", kStrangerMjcf);
  ModelDescription d = read_model(path).description();
  EffectTerm term;
  term.effect = "quadratic_drag";
  term.axis.coefficients = VectorXd::Unit(4, 1);
  term.values["coefficient"] = 0.2;
  d.effects.push_back(term);
  term.effect = "torque_offset";
  term.axis.coefficients = VectorXd::Unit(4, 2);
  term.values = {{"offset", 0.7}};
  d.effects.push_back(term);
  // The finger follows `reach` with damping of its own: the sum is not one attribute.
  for (EffectTerm& t : d.effects) {
    if (t.effect == "viscous_friction" && t.axis.coefficients[3] == 1.0) t.values["coefficient"] = 0.6;
  }
  const UpdatedFile updated = updated_mjcf(Model(d), path);
  ASSERT_EQ(updated.left_out.size(), 3U);
  EXPECT_EQ(updated.left_out[0], "quadratic_drag on pitch");
  EXPECT_EQ(updated.left_out[1], "a constant force of 0.7 on elbow");
  EXPECT_TRUE(contains_text(updated.left_out[2], "of reach, which other parts of the file share"));
  EXPECT_TRUE(contains_text(updated.xml, "<!-- left out: quadratic_drag on pitch -->"));
  EXPECT_TRUE(updated.changed.empty());
}

// A tendon without a length of its own is relaxed where its joints' springs are.
TEST_F(SimulationFile, ASpringReferenceSharedWithATendonIsKeptAndReported) {
  const std::string path = write("arm.xml", kStrangerMjcf);
  const UpdatedFile updated = updated_mjcf(extended(read_model(path), "fore"), path);
  ASSERT_EQ(updated.left_out.size(), 1U);
  EXPECT_TRUE(contains_text(updated.left_out[0], "of pitch, which other parts of the file share")) << updated.left_out[0];
  EXPECT_TRUE(contains_text(updated.xml, "springref=\"20\""));
}

// Its first joint has no name, the first body's <inertial> does not count, and the second body's frame is turned.
const char* const kFromGeoms = R"(<mujoco model="two">
  <compiler angle="degree" inertiafromgeom="true"/>
  <worldbody>
    <body name="upper">
      <inertial pos="0 0 9" mass="9" diaginertia="9 9 9"/>
      <joint axis="0 1 0" damping="0.1"/>
      <geom type="capsule" fromto="0 0 0 0 0 0.3" size="0.03"/>
      <body name="fore" pos="0 0 0.3">
        <joint name="elbow" axis="0 1 0" damping="0.1"/>
        <site name="fore" pos="0.01 0 0.02" euler="30 20 10"/>
        <geom type="capsule" fromto="0 0 0 0.1 0 0.3" size="0.02"/>
      </body>
    </body>
  </worldbody>
</mujoco>
)";

TEST_F(SimulationFile, BodiesOfGeomsKeepTheirInertia) {
  const std::string path = write("arm.xml", kFromGeoms);
  ModelDescription d = read_model(path).description();
  for (Frame& f : d.frames) {
    if (f.name == "fore") *f.body->phi *= 1.3;
  }
  const UpdatedFile updated = updated_mjcf(Model(d), path);
  EXPECT_EQ(updated.changed, std::vector<std::string>{"inertial of fore"});
  expect_same_torques(Model(d), read_model(write("new.xml", updated.xml)));
}

TEST_F(SimulationFile, AnUnnamedJointIsKeptAndReported) {
  const std::string path = write("arm.xml", kFromGeoms);
  ModelDescription d = read_model(path).description();
  for (EffectTerm& term : d.effects) term.values["coefficient"] = 0.7;
  const UpdatedFile updated = updated_mjcf(Model(d), path);
  EXPECT_EQ(updated.changed, std::vector<std::string>{"damping of elbow"});
  EXPECT_EQ(updated.left_out, std::vector<std::string>{"damping of upper_joint, a joint without a name of its own"});
}

// A refined length or another base: the inertials belong to places that the file does not have.
TEST_F(SimulationFile, DifferencesOfGravityAndFramesAreReported) {
  const std::string path = write("arm.xml", kFromGeoms);
  ModelDescription d = read_model(path).description();
  d.gravity = {0.1, 0, -9.8};
  d.frames[read_model(path).find_frame("fore")->value].A.p.z += 0.01;
  const UpdatedFile updated = updated_mjcf(Model(d), path);
  EXPECT_EQ(updated.left_out, (std::vector<std::string>{"gravity", "the place of fore"}));
  // A second export tells what it left out itself, and nothing of the first one.
  const UpdatedFile again = updated_mjcf(read_model(path), write("new.xml", updated.xml));
  EXPECT_FALSE(contains_text(again.xml, "left out"));
}

TEST_F(SimulationFile, AnotherArmsFileIsRefused) {
  const std::string path = write("arm.xml", kStrangerMjcf);
  EXPECT_THROW(updated_mjcf(read_model(write("arm.sdf", kStrangerSdf)), path), InvalidInput);
  ModelDescription d = read_model(path).description();
  for (Frame& f : d.frames) {
    if (f.name == "fore") (*f.body->phi)[9] *= -1.0;
  }
  EXPECT_THROW(updated_mjcf(Model(d), path), InvalidInput);
}

}  // namespace
}  // namespace veridyn
