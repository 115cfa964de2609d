#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>

#include "support/random.hpp"
#include "dvrk/arms/arm_facts.hpp"
#include "dvrk/config/io_config.hpp"
#include "veridyn/math/require.hpp"
#include "support/refusal.hpp"

namespace veridyn::dvrk {
namespace {

const std::string kExample =
    std::string(VERIDYN_SOURCE_DIR) + "/data/dvrk/sawRobotIO1394-PSM1-example.xml";

std::string content_of(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

// One change to the example, and the required words of the message.
struct Mistake {
  std::string from, to;
  std::vector<std::string> named;
};

// JSON that breaks off, or goes wrong, is shown where it does, in words of this library.
TEST(IoConfig, InvalidJsonIsReportedWithItsPosition) {
  const struct {
    const char* content;
    const char* says;
  } cases[] = {
      {"{\"robots\": [", "io.json:1:13: found the end of the file, expected the JSON to go on."},
      {"{\"a\": nan}", "io.json:1:7: found 'nan', expected JSON"},
      {"{\"a\":\n 1}}", "io.json:2:4: found '}', expected JSON"},
      {"{\"a\": 1,\n \"b\" 2}", "io.json:2:6: found '2', expected JSON"},
      {"{\"a\": \"\xff\"}", "io.json:1:8: found a character that is not UTF-8"},
      {"{\"a\": \"x\ny\"}", "io.json:1:9: found the end of the line"},
      {"  ", "io.json:1:1: found nothing"},
      {"{\"a\": 1e999}", "found a number too large to hold"},
      {"42", "expected {\"robots\""},
  };
  for (const auto& one : cases) {
    try {
      read_io_json(one.content, "io.json");
      ADD_FAILURE() << one.content;
    } catch (const InvalidInput& error) {
      EXPECT_NE(std::string(error.what()).find(one.says), std::string::npos) << error.what();
      EXPECT_EQ(std::string(error.what()).find("json.exception"), std::string::npos);
    }
  }
}

class OnMistakes : public testing::TestWithParam<Mistake> {};

TEST_P(OnMistakes, TheMessageNamesElementAndReason) {
  std::string xml = content_of(kExample);
  const auto place = xml.find(GetParam().from);
  ASSERT_NE(place, std::string::npos);
  xml.replace(place, GetParam().from.size(), GetParam().to);
  try {
    read_io_xml(xml, "io.xml");
    FAIL() << "nothing was thrown";
  } catch (const InvalidInput& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.rfind("io.xml:", 0), 0U) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    for (const std::string& word : GetParam().named)
      EXPECT_NE(message.find(word), std::string::npos) << message << "\n  lacks: " << word;
  }
}

std::vector<Mistake> mistakes() {
  return {
      {"Version=\"5\"", "Version=\"4\"", {":4:", "found 4", "version 5"}},
      {"<Config", "<Konfig", {"XML"}},
      {"NumOfActuator=\"7\"", "NumOfActuator=\"6\"", {"Robot PSM1", "7 actuators", "6"}},
      {"NumOfActuator=\"7\"", "", {"Robot PSM1", "no NumOfActuator"}},
      {"HardwareVersion=\"QLA1\"", "HardwareVersion=\"QLA9\"", {"QLA9", "QLA1, DQLA, dRA1"}},
      {"BoardID=\"6\" AxisID=\"1\"",
       "BoardID=\"6\" AxisID=\"0\"",
       {"Robot PSM1/Actuator 1", "board 6 axis 0", "Actuator 0"}},
      {"BoardID=\"6\" AxisID=\"1\"",
       "BoardID=\"16\" AxisID=\"1\"",
       {"Robot PSM1/Actuator 1/BoardID", "found 16", "0 to 15"}},
      {"BoardID=\"6\" AxisID=\"1\"", "BoardID=\"6\" AxisID=\"4\"", {"AxisID", "0 to 3"}},
      {"BoardID=\"6\" AxisID=\"1\"", "AxisID=\"1\"", {"Actuator 1", "no BoardID"}},
      {"Type=\"Revolute\"", "Type=\"Screw\"", {"Actuator 0/Type", "Screw", "Revolute, Prismatic"}},
      {"Unit=\"deg\"", "Unit=\"grad\"", {"Actuator 0", "grad", "rad, deg"}},
      {"Unit=\"mm\"", "Unit=\"deg\"", {"Actuator 2", "deg", "mm, cm, m"}},
      {"Unit=\"deg\"", "", {"Actuator 0", "no Unit"}},
      {"<AmpsToBits Scale=\"",
       "<AmpsToBits Scale=\"0\" Old=\"",
       {"Actuator 0/Drive/AmpsToBits/Scale", "found 0", "other than 0"}},
      {"<AmpsToBits Scale=\"-",
       "<AmpsToBits Scale=\"",
       {"Actuator 0/Drive/BitsToFeedbackAmps", "one sign"}},
      {"<AmpsToBits Scale=\"-",
       "<AmpsToBits Scale=\"x",
       {"Actuator 0/Drive/AmpsToBits/Scale", "'x"}},
      {"<AmpsToBits Scale=\"-", "<AmpsToBits Scale=\"1e999", {"finite"}},
      {"<AmpsToBits", "<AmpsTwoBits", {"Drive", "no AmpsToBits", "AmpsTwoBits"}},
      {"<NmToAmps Scale=\"", "<NmToAmps Scale=\"-", {"NmToAmps/Scale", "positive"}},
      {"<MaxCurrent Value=\"1.340\"", "<MaxCurrent Value=\"0\"", {"Drive/MaxCurrent", "positive"}},
      {"Offset=\"32826\"", "Offset=\"60000\"", {"Actuator 0", "MaxCurrent 1.34 A", "at most 1.05", "end of the converter"}},
      {"Offset=\"32826\"", "Offset=\"5500\"", {"Actuator 0", "MaxCurrent 1.34 A", "at most 1.04", "end of the converter"}},
      {"Lower=\"-91.0\"", "Lower=\"91.0\"", {"PositionLimitsSoft", "lower limit below"}},
      // Units of other numbers: radians as degrees and the reverse, millimetres as metres, pots alike.
      {"Lower=\"-53.0\" Upper=\"53.0\" Unit=\"deg\"", "Lower=\"-53.0\" Upper=\"53.0\" Unit=\"rad\"", {"io.xml:31: Robot PSM1/Actuator 1/Encoder/PositionLimitsSoft", "a travel of 6073", "at most 1080 deg", "Unit"}},
      {"Lower=\"-53.0\" Upper=\"53.0\" Unit=\"deg\"", "Lower=\"-0.925\" Upper=\"0.925\" Unit=\"deg\"", {"io.xml:31: ", "PositionLimitsSoft", "a travel of 1.85 deg, where VoltsToPosSI covers 128", "Unit"}},
      {"Upper=\"240.0\" Unit=\"mm\"", "Upper=\"240.0\" Unit=\"m\"", {"Actuator 2/Encoder/PositionLimitsSoft", "at most 1000 mm"}},
      {"Upper=\"240.0\" Unit=\"mm\"", "Upper=\"0.24\" Unit=\"mm\"", {"Actuator 2/Encoder/PositionLimitsSoft", "a travel of 0.24 mm"}},
      {"<VoltsToPosSI Scale=\"-28.50\" Offset=\"63.611\" Unit=\"deg\"", "<VoltsToPosSI Scale=\"-28.50\" Offset=\"63.611\" Unit=\"rad\"", {"Actuator 1/Encoder/PositionLimitsSoft", "VoltsToPosSI covers 7348"}},
      {"<Tolerance Axis=\"1\" Distance=\"5.0\" Latency=\"0.01\" Unit=\"deg\"", "<Tolerance Axis=\"1\" Distance=\"5.0\" Latency=\"0.01\" Unit=\"rad\"", {"Tolerance 1", "less than the travel of 106 deg"}},
      {"<Tolerance Axis=\"1\"", "<Tolerance Axis=\"0\"", {"Tolerance 1", "axis 0", "axis 1 here"}},
      {"<Tolerance Axis=\"6\"", "<Tolerance Axis=\"7\"", {"Tolerance 6", "0 to 6"}},
      {"Name=\"PSM1-Tool\"", "Name=\"PSM1-Adapter\"", {"PSM1-Adapter", "unique"}},
      {"Pressed=\"1\"", "Pressed=\"2\"", {"DigitalIn PSM1-SUJClutch/Pressed"}},
      {"BitID=\"10\"", "BitID=\"32\"", {"DigitalIn PSM1-Adapter/BitID", "0 to 31"}},
      {"<Potentiometers>",
       "<Potentiometers><JointToActuatorPosition><Row Val=\"1 0\"/></JointToActuatorPosition>",
       {"JointToActuatorPosition", "1 rows", "7"}},
      {"SN=\"00007\"", "BoardSerials=\"1234-56\"", {"Robot PSM1/BoardSerials", "'1234-56'", "BOARD=SERIAL, as 6=1234-56"}},
      {"SN=\"00007\"", "BoardSerials=\"6=1234-56 =1234-57\"", {"found '=1234-57'"}},
      {"SN=\"00007\"", "BoardSerials=\"6x=1234-56\"", {"found '6x=1234-56'"}},
      {"SN=\"00007\"", "BoardSerials=\"16=1234-56\"", {"found '16=1234-56'"}},
      {"SN=\"00007\"", "BoardSerials=\"-1=1234-56\"", {"found '-1=1234-56'"}},
      {"SN=\"00007\"", "BoardSerials=\"99999999999999999999=1\"", {"BOARD=SERIAL"}},
      {"SN=\"00007\"", "BoardSerials=\"6=\"", {"found '6='"}},
      {"<Tolerance Axis=\"6\"", "<Tolerant Axis=\"6\"", {"Potentiometers", "6 tolerances", "7, one per axis"}},
      {"Debounce=\"0.2\"", "Debounce=\"0.2s\"", {"PSM1-SUJClutch/Debounce", "'0.2s'"}},
      {"</Config>", "", {"not XML"}},
  };
}

INSTANTIATE_TEST_SUITE_P(InTheExample, OnMistakes, testing::ValuesIn(mistakes()),
                         [](const auto& mistake) { return "m" + std::to_string(mistake.index); });

TEST(IoConfig, UnknownElementsAreNamedWithTheirLine) {
  std::string xml = content_of(kExample);
  const std::vector<std::string> before = read_io_xml(xml, "io.xml").remarks;
  const auto place = xml.find("</Actuator>");
  xml.insert(place, "<Colour Shade=\"red\"/>");
  const auto line = 1 + std::count(xml.begin(), xml.begin() + static_cast<std::ptrdiff_t>(place), '\n');
  const std::vector<std::string> remarks = read_io_xml(xml, "io.xml").remarks;
  ASSERT_EQ(remarks.size(), before.size() + 1);
  EXPECT_EQ(remarks.front().rfind(text("io.xml:", line, ": "), 0), 0U) << remarks.front();
  EXPECT_NE(remarks.front().find("Colour is not known here"), std::string::npos) << remarks.front();
}

TEST(IoConfig, ASingularCouplingOfPotsIsRefused) {
  IoConfig config = nominal_config(read_arm("MTMR"));
  config.robots[0].pots_to_actuators.row(2).setZero();
  EXPECT_TRUE(refuses_with("JointToActuatorPosition: found a singular matrix", [&] { read_io_xml(to_io_xml(config), "io.xml"); }));
}

// Rows of a coupling have as many numbers as there are actuators, in either format.
TEST(IoConfig, ACouplingMatrixOfTheWrongSizeIsRefused) {
  const IoConfig config = nominal_config(read_arm("MTMR"));
  const struct {
    bool json;
    const char *from, *to, *words;
  } cases[] = {{false, "\"0 1 1 0 0 0 0\"", "\"0 1 1 0 0 0\"", "Row 2: found fewer than 7 numbers"},
               {false, "\"0 1 1 0 0 0 0\"", "\"0 one 1 0 0 0 0\"", "Row 2: found fewer than 7 numbers"},
               {false, "\"0 1 1 0 0 0 0\"", "\"0 1 1 0 0 0 0 1\"", "found '1' behind the row"},
               {true, "0,\n            1,\n            1,", "0,\n            1,", "found fewer than 7 numbers"}};
  for (const auto& c : cases) {
    std::string content = c.json ? to_io_json(config) : to_io_xml(config);
    const auto place = content.find(c.from);
    ASSERT_NE(place, std::string::npos) << content.substr(0, 3000);
    content.replace(place, std::string(c.from).size(), c.to);
    EXPECT_TRUE(refuses_with(c.words, [&] { c.json ? read_io_json(content, "f") : read_io_xml(content, "f"); }));
  }
}

TEST(IoConfig, ABrakeCurrentAboveItsMaximumIsRefused) {
  IoConfig config = nominal_config(read_arm("ECM"));
  config.robots[0].actuators[0].brake->released_current = 0.3;  // of 0.25 A
  EXPECT_TRUE(refuses_with("AnalogBrake: found a current above the brake's MaxCurrent", [&] { read_io_xml(to_io_xml(config), "f"); }));
}

// Whether a file is XML or JSON is recognised by its first character, after a byte order mark and blanks.
TEST(IoConfig, XmlAndJsonAreDistinguishedByTheFirstCharacter) {
  const IoConfig config = nominal_config(read_arm("PSM2"));
  const std::string path = testing::TempDir() + "veridyn_format_" + std::to_string(::getpid());
  for (const std::string& content : {to_io_xml(config), to_io_json(config), "\xEF\xBB\xBF \n" + to_io_json(config)}) {
    std::ofstream(path) << content;
    EXPECT_EQ(read_io_config(path).robot().name, "PSM2");
  }
  for (const char* none : {"", " \n"}) {
    std::ofstream(path) << none;
    EXPECT_THROW(read_io_config(path), InvalidInput);
  }
  std::remove(path.c_str());
  EXPECT_TRUE(refuses_with("found a folder", [] { read_io_config(testing::TempDir()); }));
}

// Axes beyond a QLA's four belong to other boards, which have ten and are not supported as drives.
TEST(IoConfig, AxisNumbersAreCheckedAgainstTheBoardType) {
  IoConfig config = nominal_config(read_arm("ECM"));
  config.robots[0].hardware = "dRA1";
  config.robots[0].actuators[3].axis = 9;
  config.robots[0].actuators[2].brake->axis = 8;
  const IoConfig back = read_io_xml(to_io_xml(config), "f");
  EXPECT_EQ(back.robots[0].hardware, "dRA1");
  EXPECT_EQ(back.robots[0].actuators[3].axis, 9);
  EXPECT_EQ(back.robots[0].actuators[2].brake->axis, 8);
  config.robots[0].hardware = "QLA1";
  EXPECT_TRUE(refuses_with("AxisID: found 8, expected a whole number from 0 to 3", [&] { read_io_xml(to_io_xml(config), "f"); }));
}

// Bytes changed, cut out and doubled at random: either a configuration, or one line that says why
// not; never another exception.
TEST(IoConfig, DamagedFilesAreReadOrRefused) {
  const std::string xml = content_of(kExample);
  const std::string json = to_io_json(read_io_xml(xml, "io.xml"));
  Random random(11);
  int refused = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    std::string text = trial % 2 == 0 ? xml : json;
    for (int change = 0; change < 1 + trial % 3; ++change) {
      const auto at = static_cast<std::size_t>(random.in(0, static_cast<double>(text.size())));
      const auto count = static_cast<std::size_t>(random.in(1, 40));
      const double kind = random.in(0, 3);
      if (kind < 1) {
        text[at] = static_cast<char>(random.in(1, 127));
      } else if (kind < 2) {
        text.erase(at, count);
      } else {
        text.insert(at, text.substr(at, count));
      }
    }
    try {
      trial % 2 == 0 ? read_io_xml(text, "f") : read_io_json(text, "f");
    } catch (const InvalidInput& error) {
      EXPECT_EQ(std::string(error.what()).rfind("f", 0), 0U) << error.what();
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000);
  std::string deep = "<Config Version=\"5\">";
  for (int k = 0; k < 100000; ++k) deep += "<a>";
  for (int k = 0; k < 100000; ++k) deep += "</a>";
  EXPECT_THROW(read_io_xml(deep + "</Config>", "f"), InvalidInput);
}

// A file of some megabytes is read in the time that its bytes take: its elements are many, not deep.
TEST(IoConfig, FiftyThousandElementsAreRead) {
  std::string xml = "<Config Version=\"5\">\n", json = "{\"digital_inputs\": [";
  constexpr int kMany = 50000;
  for (int k = 0; k < kMany; ++k) {
    xml += text("<DigitalIn Name=\"n", k, "\" BoardID=\"1\" BitID=\"2\" Pressed=\"1\"/>\n");
    json += text(k > 0 ? "," : "", "{\"name\": \"n", k, "\", \"board_id\": 1, \"bit_id\": 2}");
  }
  EXPECT_EQ(read_io_xml(xml + "<Colour/>\n</Config>", "f").remarks, std::vector<std::string>{text("f:", kMany + 2, ": Colour is not known here and was not used.")});
  EXPECT_EQ(read_io_json(json + "]}", "f").digital_inputs.size(), static_cast<std::size_t>(kMany));
}

TEST(IoConfig, AlternativeJsonKeysAreRead) {
  const std::string json = R"({"digital_inputs": [
    {"name": "a", "board_id": 1, "bit_id": 2, "pressed_value": false, "trigger_when_pressed": true,
     "trigger_when_released": false, "debounce_threshold": 0.1},
    {"name": "b", "board_id": 1, "bit_id": 3, "trigger_when_pressed": false,
     "trigger_when_released": false}]})";
  const IoConfig config = read_io_json(json, "f");
  EXPECT_TRUE(config.remarks.empty()) << config.remarks.front();
  EXPECT_FALSE(config.digital_inputs[0].pressed_when_low);
  EXPECT_EQ(config.digital_inputs[0].trigger, "press");
  EXPECT_EQ(config.digital_inputs[0].debounce, 0.1);
  EXPECT_EQ(config.digital_inputs[1].trigger, "none");
}

TEST(IoConfig, TextThatIsNoConfigurationIsRefused) {
  EXPECT_THROW(read_io_json("{", "f"), InvalidInput);
  EXPECT_THROW(read_io_json("[1]", "f"), InvalidInput);
  EXPECT_THROW(read_io_json("{\"robots\": 3}", "f"), InvalidInput);
  EXPECT_THROW(read_io_json("{\"robots\": [[1]]}", "f"), InvalidInput);
  EXPECT_THROW(read_io_json("{\"$version\": \"5\"}", "f"), InvalidInput);
  EXPECT_THROW(read_io_xml("", "f"), InvalidInput);
  EXPECT_THROW(read_io_config("/nowhere/io.xml"), InvalidInput);
  EXPECT_THROW(read_io_config(kExample).robot("PSM2"), InvalidInput);
}

}  // namespace
}  // namespace veridyn::dvrk
