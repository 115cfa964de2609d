#include "dvrk/arms/arm_facts.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "support/near.hpp"
#include "veridyn/math/require.hpp"
#include "support/refusal.hpp"

namespace veridyn::dvrk {
namespace {

const std::string kFolder = std::string(VERIDYN_SOURCE_DIR) + "/data/dvrk/";

TEST(ArmFacts, AllSixArmsAreFound) {
  EXPECT_EQ(arm_names(), (std::vector<std::string>{"ECM", "MTML", "MTMR", "PSM1", "PSM2", "PSM3"}));
  for (const std::string& name : arm_names()) {
    const ArmFacts arm = read_arm(name);
    EXPECT_EQ(arm.name, name);
    EXPECT_EQ(arm.boards.size(), 2U);
    EXPECT_EQ(arm.joints.size(), arm.actuators.size());
    // Bad configurations would be refused on reading.
    EXPECT_NO_THROW(check_io_config(nominal_config(arm), name));
    EXPECT_TRUE(read_io_xml(to_io_xml(nominal_config(arm)), name).remarks.empty()) << name;
  }
}

// Specification 12: what the laboratory's files have for these actuators.
TEST(ArmFacts, NominalScalesArePublishedOnes) {
  const std::vector<ActuatorConfig> psm = nominal_config(read_arm("PSM1")).robots[0].actuators;
  const double bits_to_position[] = {-7.7226958e-6, -7.7226958e-6, 1.2962933e-6, -1.3414145e-4,
                                     -1.3414145e-4, 1.3414145e-4,  1.3414145e-4};
  const double effort_to_amps[] = {0.4040894, 0.4040894, 0.0678284, 1.9497054,
                                   1.9497054, 1.9497054, 1.9497054};
  const double max_current[] = {1.34, 1.34, 0.67, 0.67, 0.67, 0.67, 0.67};
  for (std::size_t i = 0; i < 7; ++i) {
    // To the digits that are printed there.
    EXPECT_NEAR(psm[i].bits_to_position, bits_to_position[i], 5e-8 * std::abs(bits_to_position[i]))
        << i;
    EXPECT_NEAR(psm[i].effort_to_amps, effort_to_amps[i], 1e-6 * effort_to_amps[i]) << i;
    EXPECT_EQ(psm[i].max_current, max_current[i]) << i;
    const double sign = bits_to_position[i] < 0 ? -1.0 : 1.0;
    EXPECT_NEAR(psm[i].amps_to_bits.scale, sign * 5242.88, 1e-9);
    EXPECT_NEAR(psm[i].bits_to_amps.offset, -sign * 6.25, 1e-12);
    EXPECT_EQ(psm[i].board, i < 4 ? 6 : 7);
  }
}

// The example differs from the nominal arm by its calibration alone.
TEST(ArmFacts, TheExampleDiffersFromTheNominalArmOnlyInOffsets) {
  const IoConfig example = read_io_config(kFolder + "sawRobotIO1394-PSM1-example.xml");
  const IoConfig nominal = nominal_config(read_arm("PSM1"));
  for (std::size_t i = 0; i < 7; ++i) {
    const ActuatorConfig& a = example.robots[0].actuators[i];
    const ActuatorConfig& b = nominal.robots[0].actuators[i];
    EXPECT_EQ(a.board, b.board);
    EXPECT_EQ(a.axis, b.axis);
    EXPECT_NEAR(a.bits_to_position / b.bits_to_position, 1.0, 1e-9);
    EXPECT_NEAR(a.effort_to_amps / b.effort_to_amps, 1.0, 1e-9);
    EXPECT_NEAR(a.amps_to_bits.scale / b.amps_to_bits.scale, 1.0, 1e-9);
    EXPECT_NEAR(a.amps_to_bits.offset, b.amps_to_bits.offset, 210);
    EXPECT_NEAR(a.lower, b.lower, 1e-12);
    EXPECT_NEAR(a.upper, b.upper, 1e-12);
  }
}

TEST(ArmFacts, AnInstrumentCouplesTheLastFourActuators) {
  const ArmFacts psm = read_arm("PSM1");
  EXPECT_TRUE(near(psm.coupling(), MatrixXd::Identity(7, 7), 0.0));
  const MatrixXd K = psm.coupling("large-needle-driver-400006");
  EXPECT_EQ(K(0, 0), 1.0);
  EXPECT_EQ(K(3, 3), -1.5632);
  EXPECT_EQ(K(5, 4), -0.8306);
  EXPECT_EQ(K(6, 6), 1.2177);
  EXPECT_THROW(psm.coupling("needle"), InvalidInput);
  EXPECT_THROW(read_arm("ECM").coupling("prograsp-400093"), InvalidInput);
}

// Pots on the joints: actuators from joints by the inverse of the coupling, in both notations.
TEST(ArmFacts, PotMatrixAndCouplingOfTheMasterArmAreInverse) {
  const ArmFacts mtm = read_arm("MTML");
  EXPECT_TRUE(near(mtm.coupling() * mtm.pots_to_actuators, MatrixXd::Identity(7, 7), 1e-15));
}

TEST(ArmFacts, DefaultBoardNumbersAreTheUsualOnesOfDvrkSystems) {
  EXPECT_EQ(read_arm("MTML").boards, (std::vector<int>{0, 1}));
  EXPECT_EQ(read_arm("PSM3").boards, (std::vector<int>{10, 11}));
  EXPECT_EQ(read_arm("ECM").actuators[2].brake->board, 5);
  EXPECT_EQ(read_arm("ECM").actuators[2].brake->release_current, 0.9);
}

TEST(ArmFacts, UnverifiedFactsAreListed) {
  for (const char* name : {"PSM1", "MTML", "ECM"}) EXPECT_FALSE(read_arm(name).unsure.empty());
}

TEST(ArmFacts, AnInvalidArmFileIsRefusedWithItsReason) {
  std::ifstream file(kFolder + "psm.yaml");
  const std::string yaml{std::istreambuf_iterator<char>(file), {}};
  const std::filesystem::path path = std::filesystem::temp_directory_path() /
                                     ("veridyn_arm_" + std::to_string(::getpid()) + ".yaml");
  const auto message_of = [&](const std::string& from, const std::string& to) -> std::string {
    std::string wrong = yaml;
    const auto place = wrong.find(from);
    if (place == std::string::npos) return "no '" + from + "' in the file";
    std::ofstream(path) << wrong.replace(place, from.size(), to);
    return refusal([&] { read_arm(path.string() + ":PSM2"); });
  };
  EXPECT_EQ(message_of("PSM", "PSM"), "");
  EXPECT_NE(message_of("gear: 56.50", "gear: 0").find("positive"), std::string::npos);
  EXPECT_NE(message_of("[-1, -1, 1, -1, -1, 1, 1]}\n  - {name: PSM3",
                       "[-1, -1, 0, -1, -1, 1, 1]}\n  - {name: PSM3")
                .find("found 0, expected 1 or -1"),
            std::string::npos);
  EXPECT_NE(message_of("[-1.5632, 0, 0, 0]", "[0, 0, 0, 0]").find("singular"), std::string::npos);
  EXPECT_NE(message_of("kp: 120", "kq: 120").find("unknown key 'kq'"), std::string::npos);
  EXPECT_NE(message_of("[0, -1, 0], [0, 0, 1]", "[0, 1, 0], [0, 0, 1]").find("no rotation"),
            std::string::npos);
  EXPECT_NE(message_of("name: PSM2", "name: PSM9").find("no arm 'PSM2'"), std::string::npos);
  EXPECT_THROW(read_arm("PSM4"), InvalidInput);
  const struct {
    const char *from, *to, *words;
  } refused[] = {{"dvrk_arm: 1", "dvrk_arm: 2", "another version"},
                 {"convention: modified", "convention: modifed", "standard or modified"},
                 {"board: 0", "board: 0.5", "a whole number from 0 to 1"},
                 {"board: 0", "board: -1", "a whole number from 0 to 1"},
                 {"board: 0", "board: 2", "a whole number from 0 to 1"},
                 {"gear: 56.50", "gear: .nan", "finite number"},
                 {"max_current: ", "max_current: -", "a positive number"},
                 {"max_current: 1.34", "max_current: 6.3", "at most 6.24981 A, the end of the converter"},
                 {"position: [-91*pi/180, 91*pi/180], velocity", "position: [1, 1], velocity", "a lower limit not below the upper one"},
                 {"position: [-91*pi/180, 91*pi/180], velocity", "position: [1], velocity", "two numbers [lower, upper]"},
                 {"dh: [0, pi/2, 0, pi/2]", "dh: [0, pi/2, 0]", "four numbers"},
                 {"velocity: 2.0", "velocity: 0", "a positive number"},
                 {"prismatic: true", "prismatic: perhaps", "true or false"},
                 {"pot: [-43.5*pi/180", "pot: [0", "the scale 0"},
                 {"boards: [8, 9]", "boards: [8]", "two board ids"},
                 {"boards: [8, 9]", "boards: [8, 16]", "a whole number from 0 to 15"},
                 {"boards: [8, 9]", "boards: [8, 8]", "Actuator 4: found board 8 axis 0, which Robot PSM2/Actuator 0 has already"},
                 {"name: pitch,     board: 0, axis: 1", "name: pitch,     board: 0, axis: 0", "Actuator 1: found board 8 axis 0, which Robot PSM2/Actuator 0 has already"},
                 {"axis: 3", "axis: 4", "a whole number from 0 to 3"},
                 {"first: 3", "first: 7", "a whole number from 0 to 6"},
                 {"first: 3", "first: 2", "a matrix of 4 rows, expected 5"},
                 {"[0, 1.0186, 0, 0]", "[0, 1.0186, 0]", "4 numbers, as many as there are rows"},
                 {"  - {name: jaw, ", "  - {name: more, position: [0, 1]}\n  - {name: jaw, ", "7 actuators, expected 8"},
                 {"rotation: [[0, -1, 0], [0, 0, 1], [-1, 0, 0]]", "rotation: [[1, 0], [0, 1]]", "no rotation"},
                 {"position: [0, 0.0102, 0]", "position: [0, 0.0102]", "three numbers"},
                 {"rotation: [[0, -1, 0], [0, 0, 1], [-1, 0, 0]]", "rotation: []", "a singular matrix"}};
  for (const auto& one : refused) {
    const std::string said = message_of(one.from, one.to);
    EXPECT_NE(said.find(one.words), std::string::npos) << one.to << ": " << said;
    EXPECT_EQ(said.find(path.string() + ":"), 0U) << said;
  }
  std::filesystem::remove(path);
}

// User folders come first; one without arms is skipped.
TEST(ArmFacts, UserArmsAreFoundInTheirFolder) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(testing::TempDir()) / ("veridyn_arms_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  ASSERT_EQ(::setenv("VERIDYN_DVRK", folder.c_str(), 1), 0);
  EXPECT_EQ(arm_names().size(), 6U);
  std::ifstream file(kFolder + "ecm.yaml");
  std::string yaml{std::istreambuf_iterator<char>(file), {}};
  yaml.replace(yaml.find("convention: modified"), 20, "convention: standard");
  yaml.replace(yaml.find("{name: ECM, boards"), 18, "{name: MINE, boards");
  yaml.erase(yaml.find("unsure:"), yaml.find("convention:") - yaml.find("unsure:"));
  std::ofstream(folder / "mine.yaml") << yaml;
  std::ofstream(folder / "notes.txt") << "no arm";
  EXPECT_EQ(arm_names(), std::vector<std::string>{"MINE"});
  const ArmFacts mine = read_arm("MINE");
  EXPECT_EQ(mine.joints[0].dh->convention, DhConvention::kStandard);
  EXPECT_EQ(read_arm(kFolder + "ecm.yaml:ECM").joints[0].dh->convention, DhConvention::kModified);
  EXPECT_TRUE(mine.unsure.empty());
  EXPECT_TRUE(refuses_with("expected one of: MINE", [] { read_arm("ECM"); }));
  ::unsetenv("VERIDYN_DVRK");
  fs::remove_all(folder);
  EXPECT_NO_THROW(read_arm("ECM"));
}

TEST(ArmFacts, AnArmWithoutDhRowsHasNoChain) {
  ArmFacts arm = read_arm("PSM1");
  for (ArmJoint& joint : arm.joints) joint.dh.reset();
  EXPECT_TRUE(refuses_with("arm 'PSM1': found no joint with a DH row", [&] { arm_model(arm); }));
}

// Two brakes of one actuator, and brakes on channels of motors: one of the two would be driven by the other's currents.
TEST(ArmFacts, ABrakeHasAnActuatorAndAChannelOfItsOwn) {
  std::ifstream file(kFolder + "ecm.yaml");
  const std::string yaml{std::istreambuf_iterator<char>(file), {}};
  const std::string path = testing::TempDir() + "veridyn_brakes_" + std::to_string(::getpid()) + ".yaml";
  const struct {
    const char *from, *to, *words;
  } refused[] = {{"{actuator: 1, board", "{actuator: 0, board", "found a second brake of actuator 0"},
                 {"{actuator: 2, board", "{actuator: 4, board", "a whole number from 0 to 3"},
                 {"board: 1, axis: 2, release", "board: 0, axis: 2, release", "Actuator 2's brake: found board 4 axis 2"},
                 {"board: 1, axis: 2, release", "board: 1, axis: 1, release", "Actuator 2's brake: found board 5 axis 1"},
                 {"release: 0.90", "release: 7", "Actuator 2's brake: found MaxCurrent 7 A"},
                 {"release_time: 2, released: 0.20", "release_time: 0, released: 0.20", "a positive number"}};
  for (const auto& one : refused) {
    std::string wrong = yaml;
    const auto place = wrong.find(one.from);
    ASSERT_NE(place, std::string::npos) << one.from;
    std::ofstream(path) << wrong.replace(place, std::string(one.from).size(), one.to);
    EXPECT_TRUE(refuses_with(one.words, [&] { read_arm(path + ":ECM"); }));
  }
  std::filesystem::remove(path);
}

// A brake's channel may get the current that releases it, and no more.
TEST(ArmFacts, ABrakesHoldingCurrentIsAtMostItsReleaseCurrent) {
  std::ifstream file(kFolder + "ecm.yaml");
  const std::string yaml{std::istreambuf_iterator<char>(file), {}};
  const std::string path = testing::TempDir() + "veridyn_brake_" + std::to_string(::getpid()) + ".yaml";
  for (const char* currents : {"released: 0.8, engaged: 0}", "released: 0.08, engaged: 0.8}", "released: 0.08, engaged: -0.8}"}) {
    std::string wrong = yaml;
    const std::string right = "released: 0.08, engaged: 0}";
    std::ofstream(path) << wrong.replace(wrong.find(right), right.size(), currents);
    EXPECT_TRUE(refuses_with("a current above the one that releases", [&] { read_arm(path + ":ECM"); })) << currents;
  }
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace veridyn::dvrk
