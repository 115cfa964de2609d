#include <gtest/gtest.h>

#include "cli/tool.hpp"
#include "dvrk/config/io_config.hpp"

namespace veridyn {
namespace {

const std::string kExample =
    std::string(VERIDYN_SOURCE_DIR) + "/data/dvrk/sawRobotIO1394-PSM1-example.xml";

TEST(DvrkConfig, XmlAndJsonRoundTripKeepsTheConfiguration) {
  const TemporaryFolder folder;
  const std::string converted = folder.path("io.json");
  const std::string xml = folder.path("io.xml");
  const ToolRun there = run_tool({"dvrk", "config", "--config", kExample, "-o", converted});
  ASSERT_EQ(there.status, 0) << there.err;
  EXPECT_EQ(json_of(converted).at("$version"), "6");
  ASSERT_EQ(run_tool({"dvrk", "config", "--config", converted, "-o", xml}).status, 0);
  const dvrk::ActuatorConfig a = dvrk::read_io_config(kExample).robot().actuators[4];
  const dvrk::ActuatorConfig b = dvrk::read_io_config(xml).robot().actuators[4];
  EXPECT_NEAR(a.bits_to_position / b.bits_to_position, 1.0, 1e-14);
  EXPECT_EQ(a.amps_to_bits.offset, b.amps_to_bits.offset);
  // The table: nominal numbers of the arm, in degrees.
  EXPECT_NE(there.out.find("PSM1 on QLA1, serial number 00007"), std::string::npos) << there.out;
  EXPECT_NE(there.out.find("board  6 axis 0  -0.000442478 deg/count  -91 .. 91 deg  1.34 A"),
            std::string::npos)
      << there.out;
}

TEST(DvrkConfig, UnknownElementsAreListed) {
  const TemporaryFolder folder;
  std::string xml = content_of(kExample);
  xml.replace(xml.find("<Drive>"), 7, "<Drive><Paint Colour=\"red\"/>");
  const ToolRun run = run_tool({"dvrk", "config", "--config", folder.write("io.xml", xml)});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("io.xml:7: Robot/Actuator/Drive/Paint is not known here"),
            std::string::npos)
      << run.out;
}

TEST(DvrkConfig, UnverifiedFactsOfArmsAreListed) {
  const ToolRun run = run_tool({"dvrk", "config", "--arm", "ECM"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("note: nobody has checked: kinematics"), std::string::npos) << run.out;
}

TEST(DvrkConfig, UsageErrorsAreReported) {
  const TemporaryFolder folder;
  const ToolRun broken =
      run_tool({"dvrk", "config", "--config", folder.write("io.xml", "<Config Version=\"4\"/>")});
  EXPECT_EQ(broken.status, 3);
  EXPECT_NE(broken.err.find("io.xml:1: Version: found 4, expected version 5"), std::string::npos)
      << broken.err;
  EXPECT_EQ(run_tool({"dvrk", "config", "--arm", "PSM9"}).status, 2);
  EXPECT_EQ(run_tool({"dvrk", "config"}).status, 2);
  EXPECT_EQ(run_tool({"dvrk", "config", "--arm", "PSM1", "-o", folder.path("io.txt")}).status, 2);
  EXPECT_EQ(folder.files(), Words{"io.xml"});
}

}  // namespace
}  // namespace veridyn
