#include "veridyn/files/model_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "veridyn/math/require.hpp"
#include "effects/effect_names.hpp"
#include "support/refusal.hpp"

namespace veridyn {
namespace {

const char* const kArm = R"(veridyn: 1
name: arm
constants: {l: 0.5, half: l/2}
coordinates:
  - {name: shoulder, limits: {position: [-1, 1], velocity: 2}, drive_gain: 12.5}
  - {name: slide}
frames:
  - {name: upper, parent: world, convention: standard, dh: [l, pi/2, 0, half], revolute: {shoulder: 1}, body: true}
  - {name: tool, parent: upper, convention: modified, dh: [0, 0, 0.1, 0], prismatic: {slide: -1/l}, body: {mass: 2, com: [0, 0, l], inertia: {xx: 0.1, yz: 0.01}}}
effects:
  - {effect: viscous_friction, axis: {shoulder: 1}, coefficient: 0.3, std: {coefficient: 0.01}}
)";

// The arm with one text replaced by another.
std::string arm_with(const std::string& old_text, const std::string& new_text) {
  std::string content = kArm;
  const std::size_t at = content.find(old_text);
  EXPECT_NE(at, std::string::npos) << old_text;
  return content.replace(at, old_text.size(), new_text);
}

std::string error_of(const std::string& content, const ModelFileOptions& options = {}) {
  try {
    read_yaml(content, "arm.yaml", options);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "no error";
}

TEST(ModelFile, ReadsEveryKey) {
  const Model arm = read_yaml(kArm, "arm.yaml");
  EXPECT_EQ(arm.name(), "arm");
  EXPECT_EQ(arm.gravity(), Eigen::Vector3d(0, 0, -9.81));
  ASSERT_EQ(arm.joints(), 2);
  EXPECT_EQ(arm.coordinates()[0].limits.upper, 1.0);
  EXPECT_EQ(arm.coordinates()[0].drive_gain, 12.5);
  EXPECT_TRUE(std::isinf(arm.coordinates()[1].limits.velocity));
  EXPECT_TRUE(arm.coordinates()[1].prismatic);
  EXPECT_EQ(arm.frames()[0].variable.offset, 0.25);
  EXPECT_EQ(arm.frames()[1].variable.coefficients, Eigen::Vector2d(0, -2));
  EXPECT_EQ(arm.frames()[1].parent, FrameIndex{0});
  const InertialParameters phi = *arm.frames()[1].body->phi;
  EXPECT_EQ(phi[3], 1.0);  // m c_z
  EXPECT_EQ(phi[4], 0.6);  // 0.1 + m c_z^2
  EXPECT_EQ(phi[8], 0.01);
  EXPECT_FALSE(arm.frames()[0].body->phi);
  EXPECT_EQ(arm.effects()[0].values.at("coefficient"), 0.3);
  EXPECT_EQ(arm.effects()[0].deviations.at("coefficient"), 0.01);
  EXPECT_EQ(arm.effects()[0].where, "arm.yaml:11");
}

TEST(ModelFile, OverriddenConstantsChangeDependentFormulas) {
  ModelFileOptions options;
  options.constants["l"] = 0.8;
  const Model arm = read_yaml(kArm, "arm.yaml", options);
  EXPECT_EQ(arm.frames()[0].dh->a, 0.8);
  EXPECT_EQ(arm.frames()[0].dh->theta, 0.4);
  EXPECT_EQ(arm.frames()[1].variable.coefficients[1], -1.25);
  // ... also in a model that was written and read again.
  const Model again = read_yaml(to_yaml(read_yaml(kArm, "arm.yaml")), "again.yaml", options);
  EXPECT_EQ(again.frames()[0].dh->theta, 0.4);
}

TEST(ModelFile, OverridingAnUnknownConstantIsRefused) {
  ModelFileOptions options;
  options.constants["hlaf"] = 1.0;
  EXPECT_EQ(
      error_of(kArm, options),
      "arm.yaml:1:1: found no constant 'hlaf' (did you mean 'half'?), expected one of: half, l.");
}

TEST(ModelFile, AnOverriddenConstantIsKeptInTheWrittenFile) {
  ModelFileOptions options;
  options.constants["half"] = 0.3;
  const Model arm = read_yaml(to_yaml(read_yaml(kArm, "arm.yaml", options)), "again.yaml");
  EXPECT_EQ(arm.description().constants.at("half"), 0.3);
  EXPECT_EQ(arm.frames()[0].dh->theta, 0.3);
}

struct Mistake {
  std::string old_text;
  std::string new_text;
  std::string message;  // begins like this
};

void PrintTo(const Mistake& mistake, std::ostream* out) {
  *out << mistake.new_text;
}  // NOLINT: googletest's name

class EveryMistake : public testing::TestWithParam<Mistake> {};

TEST_P(EveryMistake, IsReportedWithItsPlaceTheFoundAndTheExpectedText) {
  const Mistake& m = GetParam();
  const std::string error = error_of(arm_with(m.old_text, m.new_text));
  EXPECT_EQ(error.substr(0, m.message.size()), m.message);
  EXPECT_NE(error.find(", expected "), std::string::npos);
  EXPECT_EQ(error.find('\n'), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Header, EveryMistake,
    testing::Values(
        Mistake{kArm, "", "arm.yaml: found nothing"},
        Mistake{kArm, "just words", "arm.yaml:1:1: found 'just words'"},
        Mistake{"name: arm\n", "name: arm\n  oops: [\n",
                "arm.yaml:3:7: found text that is not YAML ("},
        Mistake{"veridyn: 1\n", "", "arm.yaml:1:1: found no 'veridyn: 1'"},
        Mistake{"veridyn: 1\n", "veridyn: 2\n",
                "arm.yaml:1:10: found version '2', expected 'veridyn: 1'"},
        Mistake{"constants:", "constnats:",
                "arm.yaml:3:1: found the unknown key 'constnats' (did you mean 'constants'?)"},
        Mistake{"name: arm\n", "name: arm\nname: arm\n",
                "arm.yaml:3:1: found the key 'name' twice"},
        Mistake{"name: arm\n", "", "arm.yaml:1:1: found no key 'name'"},
        Mistake{"name: arm\n", "name: arm\ngravity: [0, 0]\n",
                "arm.yaml:3:10: found a list of 2, expected three numbers"},
        Mistake{"name: arm\n", "name: arm\nconvention: standart\n",
                "arm.yaml:3:13: found 'standart' (did you mean 'standard'?), expected standard or "
                "modified"},
        Mistake{"name: arm\n", "name: arm\nbox: {mass_max: -1}\n",
                "arm.yaml:3:17: found '-1', expected a positive number"}));

INSTANTIATE_TEST_SUITE_P(
    Numbers, EveryMistake,
    testing::Values(
        Mistake{"l: 0.5", "l: 0.5*(2", "arm.yaml:3:16: found '0.5*(2' ("},
        Mistake{"half: l/2", "half: ll/2",
                "arm.yaml:3:27: found 'll/2' ('ll' is neither a number nor a constant) (did "
                "you mean 'l'?)"},
        Mistake{"l: 0.5, half: l/2", "half: l/2, l: 0.5",
                "arm.yaml:3:19: found 'l/2' ('l' is neither a number nor a constant"},
        Mistake{"l: 0.5", "sin: 0.5",
                "arm.yaml:3:13: found the constant 'sin', which has a meaning already"},
        Mistake{"drive_gain: 12.5", "drive_gain: .nan", "arm.yaml:5:76: found '.nan' ("},
        Mistake{"drive_gain: 12.5", "drive_gain: 1e400",
                "arm.yaml:5:76: found '1e400' (not finite)"},
        Mistake{"drive_gain: 12.5", "drive_gain: 1/0", "arm.yaml:5:76: found '1/0' (not finite)"},
        Mistake{"drive_gain: 12.5", "drive_gain: [1]",
                "arm.yaml:5:76: found a list of 1, expected a number"},
        Mistake{"drive_gain: 12.5",
                "drive_gain:", "arm.yaml:5:75: found nothing, expected a number"}));

INSTANTIATE_TEST_SUITE_P(
    Coordinates, EveryMistake,
    testing::Values(
        Mistake{"velocity: 2", "velocty: 2",
                "arm.yaml:5:50: found the unknown key 'velocty' (did you mean 'velocity'?)"},
        Mistake{"velocity: 2", "velocity: 0",
                "arm.yaml:5:60: found '0', expected a positive number"},
        Mistake{"[-1, 1]", "[1, -1]", "arm.yaml:5:41: found [1, -1], expected lower < upper"},
        Mistake{"[-1, 1]", "[-1]",
                "arm.yaml:5:41: found a list of 1, expected two numbers [lower, upper]"},
        Mistake{"{name: slide}", "{name: shoulder}",
                "arm.yaml:6:5: found a second coordinate 'shoulder'"},
        Mistake{"{name: slide}", "slide",
                "arm.yaml:6:5: found 'slide', expected a map with the keys name, limits"},
        Mistake{"{slide: -1/l}", "{sldie: -1/l}",
                "arm.yaml:9:87: found the unknown coordinate 'sldie' (did you mean 'slide'?), "
                "expected one of: shoulder, slide"},
        Mistake{"{slide: -1/l}", "{}", "arm.yaml:9:86: found an empty map"},
        Mistake{"axis: {shoulder: 1}", "axis: {elbow: 1}",
                "arm.yaml:11:39: found the unknown coordinate 'elbow', expected"}));

INSTANTIATE_TEST_SUITE_P(
    Frames, EveryMistake,
    testing::Values(
        Mistake{"parent: upper", "parent: uper",
                "arm.yaml:9:26: found the unknown parent 'uper' (did you mean 'upper'?)"},
        Mistake{"parent: world", "parent: tool",
                "arm.yaml:8:27: found a cycle of parents (upper -> tool -> upper)"},
        Mistake{"parent: upper", "parent: tool",
                "arm.yaml:9:26: found a cycle of parents (tool -> tool)"},
        Mistake{"parent: upper",
                "parent: later, dh: [0, 0, 0, 0], convention: standard}\n  - {name: later, parent: "
                "world",
                "arm.yaml:9:26: found the parent 'later', which stands after its child 'tool', "
                "expected parents before"},
        Mistake{"name: tool", "name: upper", "arm.yaml:9:12: found a second frame 'upper'"},
        Mistake{"name: tool", "name: world", "arm.yaml:9:12: found a frame called 'world'"},
        Mistake{"[0, 0, 0.1, 0]", "[0, 0, 0.1]",
                "arm.yaml:9:59: found a list of 3, expected four numbers [a, alpha, d, theta]"},
        Mistake{"prismatic: {", "revolute: {shoulder: 1}, prismatic: {",
                "arm.yaml:9:111: found both revolute and prismatic"},
        Mistake{"prismatic:", "prismtic:",
                "arm.yaml:9:75: found the unknown key 'prismtic' (did you mean 'prismatic'?)"},
        Mistake{"convention: modified, ", "", "arm.yaml:9:5: found a dh row without convention"},
        Mistake{"dh: [0, 0, 0.1, 0]", "dh: [0, 0, 0.1, 0], axis: [1, 0, 0]",
                "arm.yaml:9:81: found both dh and axis"},
        Mistake{"convention: modified, dh: [0, 0, 0.1, 0]", "origin: {}, axis: [0, 0, 0]",
                "arm.yaml:9:51: found an axis of length zero"},
        Mistake{"convention: modified, dh: [0, 0, 0.1, 0], ", "",
                "arm.yaml:9:5: found neither dh nor origin"}));

INSTANTIATE_TEST_SUITE_P(
    Bodies, EveryMistake,
    testing::Values(Mistake{"mass: 2", "mass: -2", "arm.yaml:9:114: found the negative mass '-2'"},
                    Mistake{"mass: 2, ", "", "arm.yaml:9:107: found no key 'mass'"},
                    Mistake{"xx: 0.1", "x: 0.1",
                            "arm.yaml:9:143: found the unknown key 'x' (did you mean 'xx'?)"},
                    Mistake{"mass: 2", "mas: 2",
                            "arm.yaml:9:108: found the unknown key 'mas' (did you mean 'mass'?)"},
                    Mistake{"mass: 2", "parameters: [1, 2], mass: 2",
                            "arm.yaml:9:134: found both parameters and mass"},
                    Mistake{"body: true", "body: {parameters: [1, 2]}",
                            "arm.yaml:8:124: found a list of 2, expected ten numbers [m, hx,"},
                    Mistake{"body: true", "body: {fixed: true}",
                            "arm.yaml:8:119: found a fixed body without values"},
                    Mistake{"body: true", "body: yes please",
                            "arm.yaml:8:111: found 'yes please', expected true or false"}));

INSTANTIATE_TEST_SUITE_P(
    Effects, EveryMistake,
    testing::Values(
        Mistake{"viscous_friction", "viscous_frction",
                "arm.yaml:11:14: found the unknown effect 'viscous_frction' (did you mean "
                "'viscous_friction'?), expected one of"},
        Mistake{"viscous_friction", "none", "arm.yaml:11:14: found the unknown effect 'none'"},
        Mistake{"axis: {shoulder: 1}, ", "", "arm.yaml:11:5: found no axis"},
        Mistake{"axis: {shoulder: 1}", "axsi: {shoulder: 1}",
                "arm.yaml:11:32: found the unknown key 'axsi' (did you mean 'axis'?)"},
        Mistake{"coefficient: 0.3", "coefficient: much", "arm.yaml:11:66: found 'much' ("},
        Mistake{"coefficient: 0.3", "frame: tol",
                "arm.yaml:11:60: found the unknown frame 'tol' (did you mean 'tool'?)"}));

TEST(ModelFile, AMissingFileOrNameIsRefusedWithTheMostSimilarName) {
  const auto error_of_name = [](const std::string& name) -> std::string {
    return refusal([&] { read_model(name); });
  };
  EXPECT_EQ(error_of_name("nowhere/psm-3dof.yaml"),
            "nowhere/psm-3dof.yaml: found no such file (did you mean 'psm-3dof'?), expected a "
            "robot file.");
  EXPECT_EQ(
      error_of_name("psm-wirst")
          .find("psm-wirst: found no robot of this name (did you mean 'psm-wrist'?), expected a"),
      0U);
  EXPECT_EQ(error_of_name("/tmp").find("/tmp: found a folder"), 0U) << error_of_name("/tmp");
}

TEST(ModelFile, ASavedFileIsReadAgainAndAMissingFolderIsRefused) {
  const std::string path =
      (std::filesystem::temp_directory_path() / "veridyn_model_file_test.yaml").string();
  save_model(read_yaml(kArm, "arm.yaml"), path);
  EXPECT_EQ(read_model(path).frames().size(), 2U);
  std::remove(path.c_str());
  EXPECT_THROW(save_model(read_yaml(kArm, "arm.yaml"), "/no/such/folder/arm.yaml"), InvalidInput);
}

TEST(ModelFile, EveryEffectNameIsAcceptedInAFile) {
  for (const std::string& name : effect_names()) {
    const Model arm = read_yaml(arm_with("viscous_friction", name), "arm.yaml");
    EXPECT_EQ(arm.effects()[0].effect, name);
  }
}

// Whatever stands in a file, it is read or refused with one line; nothing else happens.
TEST(ModelFile, DamagedFilesAreRefusedAndNeverCrash) {
  const std::string whole = kArm;
  for (std::size_t k = 0; k < whole.size(); ++k) {
    EXPECT_EQ(error_of(whole.substr(0, k)).find('\n'), std::string::npos);
    for (const char c : {'\0', '{', ']', ':', '&', '*', '\t', '\xff', '9'}) {
      std::string damaged = whole;
      damaged[k] = c;
      EXPECT_NE(error_of(damaged), "");
    }
  }
}

// The section that statistics need says where it is broken.
TEST(ModelFile, RefusesABrokenSectionOfStatistics) {
  const auto with_section = [](const std::string& clusters, const std::string& more,
                               const std::string& factor) {
    return std::string(kArm) + "identified:\n  clusters: " + clusters + "\n" + more +
           "  base:\n"
           "    - {name: m_tool, unit: kg, value: 2, free: 2, of: {m_tool: 1}, factor: [1, 2, 3]}\n"
           "    - {name: hx_tool, unit: kg m, value: 0, free: 0, of: {hx_tool: 1}, factor: " +
           factor + "}\n";
  };
  EXPECT_EQ(error_of(with_section("3", "", "[1, 2, 3]")), "no error");
  const std::pair<std::string, const char*> kBroken[] = {
      {with_section("3", "", "[1, 2]"), "found a factor of 2 numbers, expected 3"},
      {with_section("2.5", "", "[1, 2, 3]"), "found '2.5', expected the number of clusters"},
      {with_section("-1", "", "[1, 2, 3]"), "found '-1', expected the number of clusters"},
      {with_section("3", "  error: [0.1]\n", "[1, 2, 3]"), "each of the 2 joints"},
      {with_section("3", "  motion: [[1, 2], [1, 2]]\n", "[1, 2, 3]"), "each of the 3 clusters"},
      {with_section("3", "  motion: [[1, 2], [1, 2], [1]]\n", "[1, 2, 3]"), "2 numbers"},
      {with_section("3", "  cluster: 3\n", "[1, 2, 3]"), "did you mean 'clusters'?"},
  };
  for (const auto& [content, words] : kBroken) {
    EXPECT_NE(error_of(content).find(words), std::string::npos) << error_of(content);
    EXPECT_EQ(error_of(content).rfind("arm.yaml:", 0), 0u) << error_of(content);
  }
  EXPECT_NE(error_of(std::string(kArm) +
                     "identified: {clusters: 3, base: [{name: a, unit: kg, value: 1, free: 1, of: "
                     "{b: 1}}]}\n")
                .find("a combination without 'a: 1'"),
            std::string::npos);
}

TEST(ModelFile, RefusesANegativeDeviationOfADriveGain) {
  EXPECT_NE(error_of(arm_with("drive_gain: 12.5", "drive_gain: 12.5, drive_gain_std: -1"))
                .find("negative standard deviation"),
            std::string::npos);
}

}  // namespace
}  // namespace veridyn
