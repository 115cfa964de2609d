#include "veridyn/report/robot_info.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

TEST(RobotInfoText, LinesHaveAtMost120Characters) {
  for (const std::string& robot : robot_names()) {
    std::istringstream lines(robot_info(read_model(robot)).report());
    for (std::string line; std::getline(lines, line);) {
      // A source is quoted as it stands.
      if (line.rfind("source: ", 0) == 0) continue;
      EXPECT_LE(line.size(), 120u) << robot << ": " << line;
      EXPECT_TRUE(line.empty() || line.back() != ' ') << robot << ": '" << line << "'";
    }
  }
}

TEST(RobotInfoText, NamesEveryCoordinateFrameAndParameter) {
  for (const std::string& robot : robot_names()) {
    const RobotInfo info = robot_info(read_model(robot));
    const std::string text = info.report();
    for (const Coordinate& c : info.arm.coordinates())
      EXPECT_NE(text.find(c.name), std::string::npos);
    for (const Frame& f : info.arm.frames()) EXPECT_NE(text.find(f.name), std::string::npos);
    for (const StandardParameter& p : info.parameters) {
      EXPECT_NE(text.find(p.name), std::string::npos) << robot << ": " << p.name;
    }
  }
}

TEST(RobotInfoText, AnArmWithoutBodiesHasNoParameters) {
  ModelDescription d = read_model("planar-2r").description();
  for (Frame& frame : d.frames) frame.body.reset();
  d.effects.clear();
  const RobotInfo info = robot_info(Model(std::move(d)));
  EXPECT_TRUE(info.parameters.empty());
  EXPECT_EQ(info.base.K.size(), 0);
  EXPECT_NE(info.report().find("0 bodies"), std::string::npos);
}

}  // namespace
}  // namespace veridyn
