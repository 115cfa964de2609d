#include <gtest/gtest.h>

#include "cli/tool.hpp"
#include "recordings/samples.hpp"

namespace veridyn {
namespace {

using nlohmann::json;

TEST(CheckOfABag, WritesRateJointsRowsAndTopics) {
  const TemporaryFolder folder;
  const std::string path = folder.path("check.json");
  const ToolRun run = run_tool({"check", sample("ros1_lz4.bag"), "--json", path});
  ASSERT_EQ(run.status, 0) << run.err;
  const json out = json_of(path);
  EXPECT_NEAR(out["rate"].get<double>(), 100.0, 1e-6);
  EXPECT_EQ(out["rows"], 200);
  EXPECT_EQ(out["joints"], (json{"elbow_joint", "shoulder_lift_joint", "shoulder_pan_joint"}));
  EXPECT_EQ(out["topics"][0]["name"], "/joint_states");
  EXPECT_EQ(out["topics"][0]["messages"], 200);
  EXPECT_EQ(out["recordings"][0]["format"], "ROS 1 bag");
  EXPECT_NE(run.out.find("topic /joint_states (sensor_msgs/JointState): 200 messages at 100 Hz"),
            std::string::npos)
      << run.out;
}

TEST(CheckOfATruncatedFile, ReportsTheTruncation) {
  const TemporaryFolder folder;
  const std::string path = folder.path("check.json");
  ASSERT_EQ(run_tool({"check", sample("mcap_cdr_truncated.mcap"), "--json", path}).status, 0);
  const json out = json_of(path);
  EXPECT_EQ(out["rows"], 142);
  ASSERT_EQ(out["recordings"][0]["remarks"].size(), 1u);
  EXPECT_NE(out["recordings"][0]["remarks"][0].get<std::string>().find("ends early"),
            std::string::npos);
}

TEST(ABagForAnotherRobot, IsRefusedInOneLine) {
  const ToolRun run = run_tool({"identify", "psm-3dof", "--train", sample("ros1_lz4.bag"), "--quiet"});
  EXPECT_EQ(run.status, 3);
  EXPECT_EQ(run.error_lines(), 1);
  EXPECT_NE(run.err.find("none that is yaw, pitch, insertion"), std::string::npos) << run.err;
}

TEST(OptionsOfRecordings, WithInvalidValuesAreUsageErrors) {
  const std::string bag = sample("ros1_lz4.bag");
  const std::pair<Words, const char*> kWrong[] = {
      {{"--units", "q=degrees"}, "expected one of: rad"},
      {{"--units", "q"}, "expected NAME=VALUE"},
      {{"--map", "=x"}, "expected NAME=VALUE"},
      {{"--fix", "yaw=x"}, "expected"}};
  for (const auto& [words, expected] : kWrong) {
    const ToolRun run = run_tool(Words{"check", bag} + words);
    EXPECT_EQ(run.status, 2) << run.err;
    EXPECT_NE(run.err.find(expected), std::string::npos) << run.err;
  }
  const ToolRun unknown = run_tool({"check", bag, "--topic", "/joint_state"});
  EXPECT_EQ(unknown.status, 3);
  EXPECT_NE(unknown.err.find("did you mean '/joint_states'?"), std::string::npos) << unknown.err;
}

// One and the same recording, written in another program's words.
TEST(ATableWithJointNames, GivesTheSameIdentification) {
  const TemporaryFolder folder;
  const std::string plain = folder.write("plain.csv", planar_recording(12.0));
  std::string other = planar_recording(12.0);
  const std::size_t end = other.find('\n');
  std::string header = other.substr(0, end);
  const std::pair<const char*, const char*> kNames[] = {
      {"dq1", "/arm/shoulder/velocity"}, {"dq2", "/arm/elbow/velocity"},
      {"tau1", "/arm/shoulder/effort"},  {"tau2", "/arm/elbow/effort"},
      {"q1", "/arm/shoulder/position"},  {"q2", "/arm/elbow/position"}};
  for (const auto& [from, to] : kNames) {
    const std::size_t at = header.find("," + std::string(from));
    if (at != std::string::npos) header.replace(at + 1, std::string(from).size(), to);
  }
  header.replace(0, 1, "__time");
  const std::string named = folder.write("named.csv", header + other.substr(end));
  std::vector<json> results;
  for (const std::string& file : {plain, named}) {
    const ToolRun run = run_tool({"identify", "planar-2r", "--train", file, "--method", "ols", "--drop-start", "0",
                                  "--drop-end", "0", "--json", folder.path("out.json")});
    ASSERT_EQ(run.status, 0) << run.err;
    results.push_back(json_of(folder.path("out.json")));
    if (file == named) {
      EXPECT_NE(run.err.find("joints matched: shoulder = shoulder, elbow = elbow"), std::string::npos) << run.err;
    }
  }
  for (std::size_t k = 0; k < results[0]["base_parameters"].size(); ++k) {
    const double a = results[0]["base_parameters"][k]["value"];
    EXPECT_NEAR(results[1]["base_parameters"][k]["value"].get<double>(), a, 1e-6 * (1.0 + std::abs(a)));
  }
}

}  // namespace
}  // namespace veridyn
