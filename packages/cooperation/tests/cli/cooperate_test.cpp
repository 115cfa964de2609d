#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>

#include "cli/tool.hpp"
#include "support/browser.hpp"

// `veridyn cooperate`: files, exit status, page.

namespace veridyn {
namespace {

using nlohmann::json;

std::string example(const std::string& name) {
  return std::string(VERIDYN_SOURCE_DIR) + "/examples/cooperate/" + name + ".yaml";
}

class Cooperate : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_.path(name); }
  TemporaryFolder folder_;
};

TEST_F(Cooperate, WritesRowsJsonAndPage) {
  const ToolRun run =
      run_tool({"cooperate", example("two-arms-spring"), "-o", path("rec.csv"), "--json",
                path("out.json"), "--report", path("out.html"), "--quiet"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_NE(run.out.find("asked 0.1 N: met"), std::string::npos) << run.out;

  const json out = json_of(path("out.json"));
  EXPECT_EQ(out["command"], "cooperate");
  EXPECT_EQ(out["status"], "done");
  EXPECT_TRUE(out["met"].get<bool>());
  const json& move = out["phases"][1];
  EXPECT_EQ(move["phase"], "move");
  EXPECT_LE(move["force_error"]["reached"].get<double>(), 0.1);
  EXPECT_EQ(move["force_error"]["asked"].get<double>(), 0.1);
  EXPECT_GT(out["largest_force"].get<double>(), 7.9);

  // Rows: 17 s at 1 kHz; the tool reads them as a recording of six joints.
  std::istringstream rows(content_of(path("rec.csv")));
  std::string line;
  std::getline(rows, line);
  EXPECT_EQ(line.rfind("t,q1,q2,q3,q4,q5,q6,dq1", 0), 0U) << line;
  EXPECT_NE(line.find("wanted_spring,force_spring,measured_spring,x_f_spring"), std::string::npos);
  long count = 0;
  while (std::getline(rows, line)) ++count;
  EXPECT_EQ(count, 17000);
  const ToolRun check = run_tool({"check", path("rec.csv"), "--quiet"});
  EXPECT_EQ(check.status, 0) << check.err;
}

TEST_F(Cooperate, EveryNumberOfThePageIsInTheJson) {
  if (browser().empty()) GTEST_SKIP() << "no browser: chromium is not installed";
  ASSERT_EQ(run_tool({"cooperate", example("two-arms-spring"), "--json", path("out.json"),
                      "--report", path("out.html"), "--quiet"})
                .status,
            0);
  const json out = json_of(path("out.json"));
  const std::vector<OpenedPage> opened = open_pages({{path("out.html"), 1200}, {path("out.html"), 400}});
  for (const OpenedPage& page : opened) {
    expect_faultless(page, &page == &opened[0] ? 1200 : 400);
    long numbers = 0;
    for (const PageElement& shown : page.with("data-from")) {
      expect_number(shown, out);
      ++numbers;
    }
    EXPECT_GT(numbers, 40);
    EXPECT_NE(page.html.find("All 5 bounds met."), std::string::npos);
  }
}

// On emulated boards: one arm's fault is reported and exits with 4, even if all bounds were met before.
TEST_F(Cooperate, AFaultOnBoardsExitsWithStatus4) {
  const std::string scenario = std::string(VERIDYN_SOURCE_DIR) + "/examples/dvrk/two-psm-spring.yaml";
  const ToolRun run = run_tool({"cooperate", scenario, "--boards", "PSM1", "PSM2", "--emulate",
                                "--stepped", "--board-fault", "power:slave@0.5", "--json",
                                path("out.json"), "--quiet"});
  EXPECT_EQ(run.status, 4) << run.err;
  EXPECT_NE(run.out.find("arm slave: no motor supply"), std::string::npos) << run.out;
  const json out = json_of(path("out.json"));
  EXPECT_FALSE(out["met"].get<bool>());
  EXPECT_EQ(out["boards"]["arm"], "slave");
  EXPECT_GT(out["boards"]["off_at"].get<double>(), out["boards"]["release_at"].get<double>());
  EXPECT_EQ(out["boards"]["power"], "power is off");
  EXPECT_EQ(run_tool({"cooperate", scenario, "--boards", "PSM1", "--emulate"}).status, 2);
  EXPECT_EQ(run_tool({"cooperate", scenario, "--boards", "PSM1", "PSM2", "--emulate", "--live", "-",
                      "--pace", "0"})
                .status,
            2);  // a pace requires a stepped clock
  EXPECT_EQ(run_tool({"cooperate", scenario, "--stepped"}).status, 2);
  EXPECT_EQ(run_tool({"cooperate", scenario, "--boards", "PSM1", "PSM2", "--emulate", "--board-fault",
                      "limb:slave@1"})
                .status,
            2);
  const std::string led = std::string(VERIDYN_SOURCE_DIR) + "/examples/dvrk/mtm-psm-teleoperation.yaml";
  EXPECT_EQ(run_tool({"cooperate", led, "--quiet"}).status, 3);
}

TEST_F(Cooperate, AHoldWithItsBoundMetIsReportedAndExitsWithStatus0) {
  const ToolRun run =
      run_tool({"cooperate", example("fault-stale"), "--json", path("out.json"), "--quiet"});
  EXPECT_EQ(run.status, 0) << run.err;  // the required bound is met nevertheless
  EXPECT_NE(run.out.find("samples are too old"), std::string::npos);
  const json out = json_of(path("out.json"));
  EXPECT_EQ(out["status"], "held");
  EXPECT_TRUE(out["met"].get<bool>());
  EXPECT_NEAR(out["held_at"].get<double>(), 4.52, 0.01);
}

TEST_F(Cooperate, AMissedBoundExitsWithStatus4) {
  std::string content = content_of(example("gazebo-y"));
  content.replace(content.find("steady_error: 0.1"), 17, "steady_error: 1e-9");
  const ToolRun run = run_tool({"cooperate", folder_.write("s.yaml", content), "--quiet"});
  EXPECT_EQ(run.status, 4);
  EXPECT_NE(run.out.find("NOT met"), std::string::npos);
}

TEST_F(Cooperate, ASweepWritesAMapOverTwoParameters) {
  std::string content = content_of(example("two-arms-string"));
  content = content.substr(0, content.find("  - {name: turn")) +
            "sweep: {stiffness: [1000, 20000], delay: [0, 0.002], stable_error: 0.25}\n";
  const std::string scenario = folder_.write("s.yaml", content);
  const ToolRun run = run_tool({"cooperate", scenario, "--sweep", "--threads", "1", "--json",
                                path("out.json"), "--report", path("out.html"), "--quiet"});
  ASSERT_EQ(run.status, 0) << run.err;
  const json out = json_of(path("out.json"));
  ASSERT_EQ(out["points"].size(), 4U);
  EXPECT_EQ(out["points"][1]["stiffness"], 20000.0);
  EXPECT_EQ(out["points"][1]["delay"], 0.0);
  EXPECT_EQ(out["points"][2]["delay"], 0.002);
  for (const json& point : out["points"]) EXPECT_TRUE(point["stable"].get<bool>());
  EXPECT_EQ(out["stable_region"][0]["delay_up_to"], 0.002);
  if (browser().empty()) GTEST_SKIP() << "no browser: chromium is not installed";
  const OpenedPage page = open_page(path("out.html"), 1200);
  for (const PageElement& shown : page.with("data-from")) expect_number(shown, out);
  EXPECT_EQ(page.root().at("data-errors"), "0");
}

// As after a kill: the second point is complete, the others are missing, the last is cut within its line.
TEST_F(Cooperate, AKilledSweepResumes) {
  std::string content = content_of(example("two-arms-string"));
  content = content.substr(0, content.find("  - {name: turn")) + "sweep: {stiffness: [1000, 20000], stable_error: 0.25}\n";
  const Words command = {"cooperate", folder_.write("s.yaml", content), "--sweep", "--threads", "1", "--quiet",
                         "--json", path("out.json"), "--resume", path("points")};
  ASSERT_EQ(run_tool(command).status, 0);
  json whole = json_of(path("out.json"));
  const std::string points = content_of(path("points"));
  const std::size_t first = points.find('\n') + 1, second = points.find('\n', first) + 1;
  std::string marked = points.substr(second);
  ASSERT_EQ(marked.rfind("1 20000 0.002 ", 0), 0U) << points;
  marked.replace(0, 7, "1 20001");
  folder_.write("points", points.substr(0, first) + marked + "0 1000 0.002 7");
  ASSERT_EQ(run_tool(command).status, 0);
  json resumed = json_of(path("out.json"));
  EXPECT_EQ(resumed["points"][0], whole["points"][0]);
  EXPECT_EQ(resumed["points"][1]["stiffness"], 20001.0);
  folder_.write("s.yaml", content + "# changed\n");
  const ToolRun other = run_tool(command);
  EXPECT_EQ(other.status, 3);
  EXPECT_NE(other.err.find("points:1: found"), std::string::npos) << other.err;
}

TEST_F(Cooperate, UsageErrorsAreOneLine) {
  const auto expect_line = [&](const Words& words, int status, const std::string& said) {
    const ToolRun run = run_tool(Words{"cooperate"} + words);
    EXPECT_EQ(run.status, status) << run.err;
    EXPECT_EQ(run.error_lines(), 1) << run.err;
    EXPECT_NE(run.err.find(said), std::string::npos) << run.err;
  };
  expect_line({path("none.yaml")}, 3, "no such file");
  expect_line({folder_.write("a.yaml", "veridyn: 1\nname: robot\n")}, 3, "a.yaml:1");
  std::string content = content_of(example("gazebo-y"));
  const auto at = content.find("frame: tool");
  content.replace(at, 11, "frame: tolo");
  const std::string line =
      std::to_string(1 + std::count(content.begin(), content.begin() + at, '\n'));
  expect_line({folder_.write("b.yaml", content)}, 3, "b.yaml:" + line + ": arm '");
  expect_line({path("b.yaml")}, 3, "(did you mean 'tool'?), expected one of psm-3dof: mount, yaw");
  content = content_of(example("gazebo-y"));
  const auto duration = content.find("duration: ");
  content.replace(duration, 11, "duration: 1e9");
  expect_line({folder_.write("c.yaml", content)}, 3, "what this machine holds");
  expect_line({example("gazebo-y"), "--sweep"}, 3, "no sweep");
  expect_line({example("gazebo-y"), "--resume", path("points")}, 2, "--sweep");
  expect_line({example("gazebo-y"), "--engine", "bullet"}, 2, "bullet");
  expect_line({example("gazebo-y"), "--json", "x", "--report", "x"}, 2, "the same file");
  expect_line({}, 2, "SCENARIO");
}

}  // namespace
}  // namespace veridyn
