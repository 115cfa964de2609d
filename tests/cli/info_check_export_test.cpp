#include <gtest/gtest.h>

#include <sstream>

#include "cli/tool.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

using nlohmann::json;

TEST(Info, TextAndJsonAgreeOnEveryRobot) {
  const TemporaryFolder folder;
  for (const std::string& robot : robot_names()) {
    const std::string path = folder.path(robot + ".json");
    const ToolRun run = run_tool({"info", robot, "--json", path});
    ASSERT_EQ(run.status, 0) << run.err;
    const json out = json_of(path);
    EXPECT_EQ(out["robot"], robot);
    EXPECT_NE(run.out.find(std::to_string(out["base_parameters"].size()) + " base parameters"),
              std::string::npos)
        << run.out;
    EXPECT_EQ(out["standard_parameters"].size(), out["identifiable_alone"].size() +
                                                     out["identifiable_in_combination"].size() +
                                                     out["unidentifiable"].size());
  }
}

// Published counts (README of the recordings) and those of the house's plan.
TEST(Info, CountsTheBaseParametersThatArePublished) {
  const TemporaryFolder folder;
  const std::pair<const char*, std::size_t> kCounts[] = {{"psm-wrist", 49},
                                                         {"psm-3dof", 25},
                                                         {"psm-3dof-printed", 28},
                                                         {"ur10e", 58},
                                                         {"kuka-lwr4", 43}};
  for (const auto& [robot, count] : kCounts) {
    const ToolRun run = run_tool({"info", robot, "--json", folder.path("info.json")});
    ASSERT_EQ(run.status, 0) << run.err;
    EXPECT_EQ(json_of(folder.path("info.json"))["base_parameters"].size(), count) << robot;
  }
}

TEST(Info, ASeparatelyIdentifiableParameterIsItsOwnExpression) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_tool({"info", "psm-3dof", "--json", folder.path("info.json")}).status, 0);
  const json out = json_of(folder.path("info.json"));
  for (const json& name : out["identifiable_alone"]) {
    bool found = false;
    for (const json& b : out["base_parameters"]) found = found || b["expression"] == name;
    EXPECT_TRUE(found) << name;
  }
}

TEST(Check, FindingsDoNotChangeTheExitStatus) {
  const TemporaryFolder folder;
  const std::string good = folder.write("good.csv", planar_recording(10.0));
  const std::string still = folder.write("still.csv", planar_recording(10.0, 1.0, 0.0));
  const ToolRun run = run_tool({"check", good, still, "--json", folder.path("check.json")});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.err, "");
  const json out = json_of(folder.path("check.json"));
  EXPECT_EQ(out["command"], "check");
  ASSERT_EQ(out["recordings"].size(), 2u);
  EXPECT_EQ(out["recordings"][0]["file"], good);
  EXPECT_EQ(out["recordings"][0]["rows"], 1000);
  EXPECT_NEAR(out["recordings"][0]["rate"].get<double>(), 100.0, 1e-6);
  std::size_t findings = 0;
  for (const json& r : out["recordings"]) findings += r["findings"].size();
  EXPECT_EQ(out["data_quality"].size(), findings);
  bool rests = false;
  for (const json& f : out["data_quality"]) {
    for (const char* key : {"file", "finding", "share", "severity", "sentence"}) {
      EXPECT_TRUE(f.contains(key)) << f;
    }
    EXPECT_NE(run.out.find(f["sentence"].get<std::string>()), std::string::npos) << f;
    rests = rests || (f["finding"] == "joint_at_rest" && f["file"] == still && f["joint"] == 2);
  }
  EXPECT_TRUE(rests) << run.out;
}

TEST(Check, TheColumnsAndRowsOptionsApplyToHeaderlessFiles) {
  const TemporaryFolder folder;
  std::string content = planar_recording(10.0);
  const std::string bare = folder.write("bare.csv", content.substr(content.find('\n') + 1));
  const ToolRun run = run_tool({"check", bare, "--columns", "t,q,dq,tau", "--rows", "100:700",
                                "--json", folder.path("check.json")});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(json_of(folder.path("check.json"))["recordings"][0]["rows"], 600);
}

TEST(Export, WritesModelsThatCanBeReadAgain) {
  const TemporaryFolder folder;
  const std::string yaml = folder.path("arm.yaml");
  const ToolRun run = run_tool({"export", "elbow-6r", "--yaml", yaml});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(to_yaml(read_model(yaml)), to_yaml(read_model("elbow-6r")));
  const std::string urdf = folder.path("arm.urdf");
  const ToolRun other = run_tool({"export", yaml, "--urdf", urdf});
  ASSERT_EQ(other.status, 0) << other.err;
  EXPECT_EQ(read_model(urdf).joints(), 6);
}

}  // namespace
}  // namespace veridyn
