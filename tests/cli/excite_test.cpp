#include <gtest/gtest.h>

#include <sstream>

#include "cli/tool.hpp"

namespace veridyn {
namespace {

const Words kQuick = {"--starts", "2", "--iterations", "30", "--quiet"};

TEST(Excite, WritesMotionCoefficientsAndMargins) {
  const TemporaryFolder folder;
  const ToolRun run =
      run_tool(Words{"excite", "psm-3dof", "-o", folder.path("m.csv"), "--json",
                     folder.path("m.json"), "--coefficients", folder.path("m.yaml")} +
               kQuick);
  ASSERT_EQ(run.status, 0) << run.err;
  std::istringstream csv(content_of(folder.path("m.csv")));
  std::string header;
  std::getline(csv, header);
  EXPECT_EQ(header, "t,q1,q2,q3,dq1,dq2,dq3,ddq1,ddq2,ddq3");
  const nlohmann::json out = json_of(folder.path("m.json"));
  EXPECT_EQ(out["status"], "done");

  EXPECT_LT(out["condition_number"], out["start_condition_number"]);
  EXPECT_EQ(out["margins"].size(), 6U);
  for (const auto& margin : out["margins"]) EXPECT_GE(margin["margin"], 0.0) << margin;
  const std::string yaml = content_of(folder.path("m.yaml"));
  EXPECT_NE(yaml.find("  - name: insertion\n    q0: "), std::string::npos) << yaml;
}

TEST(Excite, TheSameSeedWritesTheSameFile) {
  const TemporaryFolder folder;
  for (const char* threads : {"1", "2"}) {
    const ToolRun run = run_tool(Words{"excite", "psm-3dof", "-o", folder.path(threads), "--seed",
                                       "3", "--threads", threads} +
                                 kQuick);
    ASSERT_EQ(run.status, 0) << run.err;
  }
  EXPECT_EQ(content_of(folder.path("1")), content_of(folder.path("2")));
}

TEST(Excite, LimitsThatCannotBeMetAreNamedAndNothingIsWritten) {
  const TemporaryFolder folder;
  const ToolRun run = run_tool(Words{"excite", "psm-3dof", "-o", folder.path("m.csv"), "--box",
                                     "tool:5,6,-inf,inf,-inf,inf"} +
                               kQuick);
  EXPECT_EQ(run.status, 4);
  EXPECT_NE(run.err.find("x of tool must stay within 5 .. 6 m"), std::string::npos) << run.err;
  EXPECT_EQ(run.error_lines(), 1);
  EXPECT_TRUE(folder.files().empty());
}

TEST(Excite, ToldRivalsItSaysWhatIsLeftOfThem) {
  const TemporaryFolder folder;
  const ToolRun run =
      run_tool(Words{"excite", "psm-3dof", "-o", folder.path("m.csv"), "--json",
                     folder.path("m.json"), "--between", "payload:tool,torque_gain:2"} +
               kQuick);
  ASSERT_EQ(run.status, 0) << run.err;
  const nlohmann::json out = json_of(folder.path("m.json"))["discrimination"];
  EXPECT_TRUE(out["bodies_known"]);
  for (const double share : out["share_left"]) {
    EXPECT_GT(share, 0.2);
    EXPECT_LE(share, 1.0 + 1e-9);
  }
}

TEST(Excite, WordsThatMakeNoSenseAreUsageErrors) {
  const TemporaryFolder folder;
  const Words base = {"excite", "psm-3dof", "-o", folder.path("m.csv")};
  for (const Words& wrong : std::vector<Words>{{"--between", "payload"},
                                               {"--box", "tool:1,2"},
                                               {"--sphere", "tool:-1"},
                                               {"--obstacle", "1,2,3"},
                                               {"--insertion", "tool"},
                                               {"--solver", "snopt"}}) {
    const ToolRun run = run_tool(base + wrong);
    EXPECT_EQ(run.status, 2) << wrong[0] << run.err;
    EXPECT_EQ(run.error_lines(), 1) << run.err;
  }
  EXPECT_EQ(run_tool(base + Words{"--box", "nowhere:0,1,0,1,0,1"}).status, 3);
  EXPECT_TRUE(folder.files().empty());
}

}  // namespace
}  // namespace veridyn
