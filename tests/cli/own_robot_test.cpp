#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <regex>

#include "cli/tool.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/identification/verdict.hpp"
#include "veridyn/files/model_file.hpp"

// A URDF as makers write them, without friction, and the arm that was built from it, which is in no
// table: bodies off the drawing, friction, rotors.

namespace veridyn {
namespace {

using nlohmann::json;

const std::string kFolder = std::string(VERIDYN_SOURCE_DIR) + "/examples/own_robot/";
const std::string kUrdf = kFolder + "labarm.urdf";

class OwnRobot : public testing::Test {
 protected:
  // Two recordings of the arm as it was built, with whatever is hidden in it.
  static void record(const Words& hidden, const char* name) {
    for (const char* k : {"1", "2"}) {
      const std::string motion = folder().path(std::string("motion") + k + ".csv");
      if (!std::ifstream(motion)) {
        const ToolRun excite = run_tool({"excite", kUrdf, "-o", motion, "--frequency", std::string("0.1") + k,
                                         "--seed", k, "--starts", "1", "--iterations", "60", "--quiet"});
        ASSERT_EQ(excite.status, 0) << excite.err;
      }
      const ToolRun simulate =
          run_tool(Words{"simulate", kFolder + "true-arm.yaml", "--trajectory", motion, "-o",
                         path(name, k), "--noise", "low", "--seed", k, "--quiet"} +
                   hidden);
      ASSERT_EQ(simulate.status, 0) << simulate.err;
    }
  }
  static void SetUpTestSuite() {
    ::setenv("SOURCE_DATE_EPOCH", "1700000000", 1);
    record({}, "plain");
  }
  static void TearDownTestSuite() { ::unsetenv("SOURCE_DATE_EPOCH"); }
  static const TemporaryFolder& folder() {
    static const TemporaryFolder kTemporary;
    return kTemporary;
  }
  static std::string path(const std::string& name, const std::string& k) {
    return folder().path(name + k + ".csv");
  }
  static double value_of(const Model& model, const std::string& effect, int joint) {
    for (const JointNumber& n : plain_friction_of(model))
      if (n.effect == effect && n.joint.value == joint) return n.value;
    return NAN;
  }
};

// The same URDF and recordings give the same MODEL through every door. (Python's is compared with the
// command's in python/tests/test_identification.py.)
TEST_F(OwnRobot, CommandAndLibraryIdentifyTheSameModelToTheLastBit) {
  const std::string by_command = folder().path("command.yaml");
  const ToolRun run = run_tool({"identify", kUrdf, "--train", path("plain", "1"), "--test",
                                path("plain", "2"), "--model-out", by_command});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("has no friction: viscous and Coulomb friction"), std::string::npos) << run.out;
  const Identification id =
      identify(read_model(kUrdf), {path("plain", "1")}, {path("plain", "2")});
  ASSERT_TRUE(id.model.has_value()) << id.reason;
  save(id, folder().path("library.yaml"), "identify", kUrdf);
  EXPECT_EQ(content_of(by_command), content_of(folder().path("library.yaml")));
  EXPECT_EQ(id.model->description().values, RobotValues::kFacts);
  EXPECT_LT(id.test_error.relative.maxCoeff(), 0.06) << id.test_error.relative.transpose();
  ASSERT_FALSE(id.remarks.empty());
  // Truths of true-arm.yaml; the rotors of the first two joints are part of their links' inertia.
  EXPECT_NEAR(value_of(*id.model, "viscous_friction", 0), 1.4, 0.1);
  EXPECT_NEAR(value_of(*id.model, "coulomb_friction", 2), 1.1, 0.1);
  EXPECT_NEAR(value_of(*id.model, "rotor_inertia", 2), 0.12, 0.03);
  EXPECT_TRUE(std::isnan(value_of(*id.model, "rotor_inertia", 0)));
}

TEST_F(OwnRobot, WithFrictionOfTheFileOnlyNoEffectIsAdded) {
  IdentificationOptions options;
  options.friction = JointFriction::kFile;
  const Identification id = identify(read_model(kUrdf), {path("plain", "1")}, {}, options);
  ASSERT_TRUE(id.model.has_value());
  EXPECT_TRUE(id.model->effects().empty());
  EXPECT_GT(id.train_error.relative.maxCoeff(), 0.2);
  ASSERT_FALSE(id.remarks.empty());
  EXPECT_NE(id.remarks[0].find("`plain`"), std::string::npos) << id.remarks[0];
}

// What torques leave open stays near the maker's bodies, in the MODEL and in what is made of it.
TEST_F(OwnRobot, UndeterminedInertiasStayNearThoseOfTheRobotFile) {
  const Model maker = read_model(kUrdf);
  const Identification id = identify(maker, {path("plain", "1")});
  ASSERT_TRUE(id.model.has_value());
  save(id, folder().path("near.yaml"));
  const Model model = read_model(folder().path("near.yaml"));
  for (const auto [k] : model.bodies()) {
    const Body& body = *model.frames()[k].body;
    const Body& drawn = *maker.frames()[k].body;
    ASSERT_TRUE(body.prior.has_value());
    EXPECT_LT(((*body.prior) - (*drawn.phi)).norm(), 1e-9 * drawn.phi->norm());
    EXPECT_LT((*body.phi)[0], 3.0 * (*drawn.phi)[0]) << model.frames()[k].name;
    EXPECT_GT((*body.phi)[0], (*drawn.phi)[0] / 3.0) << model.frames()[k].name;
  }
  const std::string urdf = folder().path("out.urdf");
  ASSERT_EQ(run_tool({"export", folder().path("near.yaml"), "--urdf", urdf, "--quiet"}).status, 0);
  const Model exported = read_model(urdf);
  for (const auto [k] : maker.bodies()) {
    const Frame& drawn = maker.frames()[k];
    const Frame& out = exported.frames()[exported.find_frame(drawn.name)->value];
    EXPECT_NEAR((*out.body->phi)[0], (*drawn.body->phi)[0], 0.2 * (*drawn.body->phi)[0]) << drawn.name;
  }
}

// --prior with point masses, with bodies that cannot be and with ones far away.
TEST_F(OwnRobot, TheFitConvergesForEveryPriorBody) {
  const Model maker = read_model(kUrdf);
  const auto changed = [&](auto change) {
    ModelDescription d = maker.description();
    for (Frame& frame : d.frames)
      if (frame.body) change(*frame.body->phi);
    return Model(std::move(d));
  };
  const auto point = [](InertialParameters& phi) {
    const Eigen::Vector3d c = phi.segment<3>(1) / phi[0];
    phi = inertial_parameters(phi[0], c, Eigen::Matrix<double, 6, 1>::Zero());
  };
  const auto heavy = [](InertialParameters& phi) { phi *= 30.0; };
  const auto light = [](InertialParameters& phi) { phi *= 0.01; };
  const auto impossible = [](InertialParameters& phi) { phi[4] *= 100.0; };
  const Identification without = identify(maker, {path("plain", "1")}, {path("plain", "2")});
  for (const Model& prior : {maker, changed(point), changed(heavy), changed(light), changed(impossible)}) {
    IdentificationOptions options;
    options.prior = prior;
    const Identification id = identify(maker, {path("plain", "1")}, {path("plain", "2")}, options);
    ASSERT_EQ(id.status, IdentificationStatus::kDone) << id.reason;
    for (int i = 0; i < maker.joints(); ++i)
      EXPECT_LT(id.test_error.relative[i], 1.2 * without.test_error.relative[i] + 0.003) << i;
  }
}

TEST_F(OwnRobot, TheVerdictNamesTheJointWithUnmodelledFriction) {
  record({"--effect", "position_dependent_friction:elbow:slope=0.3,curvature=0"}, "grows");
  const std::string out = folder().path("strib.json");
  const ToolRun run = run_tool({"identify", kUrdf, "--train", path("grows", "1"), "--test",
                                path("grows", "2"), "--json", out});
  ASSERT_EQ(run.status, 0) << run.err;
  const json verdict = json_of(out)["verdict"];
  ASSERT_EQ(verdict["joints"].size(), 4u);
  EXPECT_EQ(verdict["joints"][2]["state"], "unexplained") << verdict;
  EXPECT_EQ(verdict["joints"][3]["state"], "at_floor") << verdict;
  for (const int other : {0, 1, 3}) {  // bodies that bend towards the elbow's friction cost these a little
    EXPECT_LT(verdict["joints"][other]["error"].get<double>(), 0.5 * verdict["joints"][2]["error"].get<double>()) << verdict;
  }
  const std::string sentence = verdict["sentence"];
  EXPECT_EQ(run.out.substr(0, sentence.size()), sentence);
  EXPECT_NE(sentence.find("elbow leave"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("veridyn diagnose"), std::string::npos) << sentence;
}

// The hidden cause is the first finding: what every joint has is one line and a table.
TEST_F(OwnRobot, DiagnosisOfAFileWithoutFrictionNamesTheHiddenCauseFirst) {
  record({"--effect", "stribeck_friction:elbow:level=1.3,velocity=0.25"}, "strib");
  const std::string out = folder().path("diagnosis.json");
  const ToolRun run = run_tool({"diagnose", kUrdf, "--train", path("strib", "1"), "--test",
                                path("strib", "2"), "--json", out});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("has no friction"), std::string::npos) << run.out;
  const json d = json_of(out);
  ASSERT_FALSE(d["findings"].empty()) << run.out;
  EXPECT_EQ(d["findings"][0]["effect"], "stribeck_friction") << run.out;
  EXPECT_EQ(d["findings"][0]["joint"], 3);
  EXPECT_GE(d["friction"].size(), 12u);
  for (const json& finding : d["findings"]) EXPECT_NE(finding["effect"], "coulomb_friction") << finding;
}

TEST_F(OwnRobot, DriveGainsConvertCurrentsToTorques) {
  const Model maker = read_model(kUrdf);
  std::string csv = content_of(path("plain", "1"));
  csv = std::regex_replace(csv.substr(0, csv.find('\n')), std::regex("tau([0-9])"), "i$1") +
        csv.substr(csv.find('\n'));
  const std::string rec = folder().write("currents.csv", csv);
  const ToolRun refused = run_tool({"identify", kUrdf, "--train", rec});
  EXPECT_EQ(refused.status, 3);
  EXPECT_NE(refused.err.find("--drive-gains"), std::string::npos) << refused.err;
  const std::string out = folder().path("currents.json");
  ASSERT_EQ(run_tool({"identify", kUrdf, "--train", rec, "--drive-gains", "2,2,2,2", "--json", out}).status, 0);
  const std::string plain = folder().path("plain.json");
  ASSERT_EQ(run_tool({"identify", kUrdf, "--train", path("plain", "1"), "--json", plain}).status, 0);
  const double error = json_of(out)["train"]["relative_error"][1];
  EXPECT_NEAR(error, json_of(plain)["train"]["relative_error"][1], 0.01 * error);
  const ToolRun wrong = run_tool({"identify", kUrdf, "--train", rec, "--drive-gains", "2,2"});
  EXPECT_EQ(wrong.status, 2);
  EXPECT_EQ(wrong.error_lines(), 1);
}

TEST_F(OwnRobot, InfoWritesAReadableRobotFile) {
  const std::string yaml = folder().path("info.yaml");
  ASSERT_EQ(run_tool({"info", kUrdf, "--yaml", yaml}).status, 0);
  const Model model = read_model(yaml);
  EXPECT_EQ(model.description().values, RobotValues::kPrior);  // it stays a maker's file
  EXPECT_EQ(model.bodies().size(), 4u);
}

TEST_F(OwnRobot, AModelFileMustEndInYaml) {
  const std::string out = folder().path("model.urdf");
  const ToolRun run = run_tool({"identify", kUrdf, "--train", path("plain", "1"), "--model-out", out});
  EXPECT_EQ(run.status, 2);
  EXPECT_EQ(run.error_lines(), 1) << run.err;
  EXPECT_NE(run.err.find("expected a .yaml file"), std::string::npos) << run.err;
  EXPECT_FALSE(std::ifstream(out));
}

TEST_F(OwnRobot, AFileExtensionOfAnotherFormatIsRefused) {
  const std::string model = folder().path("endings.yaml");
  save(identify(read_model(kUrdf), {path("plain", "1")}, {path("plain", "2")}), model);
  for (const auto& [option, name, expected] : std::vector<std::array<const char*, 3>>{
           {"--yaml", "m.json", ".yaml"}, {"--urdf", "m.yaml", ".urdf"}, {"--mjcf", "m.sdf", ".xml"}, {"--report", "m.json", ".html"}}) {
    const ToolRun run = run_tool({"export", model, option, folder().path(name)});
    EXPECT_EQ(run.status, 2) << option;
    EXPECT_EQ(run.error_lines(), 1) << run.err;
    EXPECT_NE(run.err.find(std::string("expected a ") + expected + " file"), std::string::npos) << run.err;
    EXPECT_FALSE(std::ifstream(folder().path(name)));
  }
  EXPECT_EQ(run_tool({"excite", kUrdf, "-o", folder().path("m.urdf")}).status, 2);
  const ToolRun page = run_tool({"export", model, "--urdf", folder().path("m.urdf"), "--report", folder().path("m.html")});
  EXPECT_EQ(page.status, 0) << page.err;
  EXPECT_NE(page.err.find("near the bodies of the robot file"), std::string::npos) << page.err;
  EXPECT_NE(content_of(folder().path("m.html")).find("upper_arm"), std::string::npos);
}

TEST_F(OwnRobot, HelpAndPrefixesOfNamesAreAccepted) {
  const ToolRun help = run_tool({"help", "identify"});
  EXPECT_EQ(help.status, 0);
  EXPECT_EQ(help.out, run_tool({"identify", "--help"}).out);
  EXPECT_NE(run_tool({"info", "psm"}).err.find("did you mean 'psm-3dof'"), std::string::npos)
      << run_tool({"info", "psm"}).err;
}

}  // namespace
}  // namespace veridyn
