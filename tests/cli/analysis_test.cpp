#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "cli/tool.hpp"
#include "support/browser.hpp"

// `veridyn stability` and `veridyn kinematics`: options, files, exit status.

namespace veridyn {
namespace {

using nlohmann::json;

std::string example(const std::string& name) {
  return std::string(VERIDYN_SOURCE_DIR) + "/examples/cooperate/" + name + ".yaml";
}

class Analysis : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_.path(name); }
  TemporaryFolder folder_;
};

TEST_F(Analysis, StabilityJsonHasTheKeysOfTheContract) {
  const ToolRun run = run_tool({"stability", example("two-arms-spring"), "--map",
                                "stiffness=500:50000:6,delay=0:0.02:4", "--locus", "gain=0.05:20:8",
                                "--recommend", "45", "--bounds", "2", "--json", path("out.json"),
                                "--quiet"});
  ASSERT_EQ(run.status, 0) << run.err;
  const json out = json_of(path("out.json"));
  EXPECT_TRUE(out["stable"].get<bool>());
  double largest = 0.0;
  for (const json& one : out["eigenvalues"])
    largest = std::max(largest, std::hypot(one[0].get<double>(), one[1].get<double>()));
  EXPECT_LT(largest, 1.0);
  EXPECT_GT(out["margins"]["gain"].get<double>(), 1.0);
  EXPECT_GT(out["margins"]["phase_deg"].get<double>(), 30.0);
  EXPECT_GT(out["margins"]["delay_s"].get<double>(), 0.001);
  EXPECT_GT(out["largest_stable_stiffness"].get<double>(), 20000.0);
  EXPECT_TRUE(out.contains("map"));
  EXPECT_NE(run.out.find("Recommended for a phase margin of 45 degrees"), std::string::npos);
  EXPECT_NE(run.out.find("Bounds: 0 of 2 corners"), std::string::npos) << run.out;
  // The gain that the map's own parameters make unstable is found by the locus.
  EXPECT_NE(run.out.find("begins to swing"), std::string::npos) << run.out;
}

// What --set changes is what is analysed: beyond the largest stable stiffness the loop is not.
TEST_F(Analysis, TheSetOptionChangesTheAnalysedScenario) {
  ASSERT_EQ(run_tool({"stability", example("two-arms-spring"), "--json", path("a.json"), "--quiet"}).status, 0);
  const double most = json_of(path("a.json"))["linear_stable_stiffness"].get<double>();
  for (const double factor : {0.97, 1.03}) {
    ASSERT_EQ(run_tool({"stability", example("two-arms-spring"), "--set",
                        "stiffness=" + std::to_string(factor * most), "--json", path("b.json"),
                        "--quiet"})
                  .status,
              0);
    EXPECT_EQ(json_of(path("b.json"))["stable"].get<bool>(), factor < 1.0) << factor;
  }
}

TEST_F(Analysis, StabilityAcceptsAModelFile) {
  for (const char* model : {"psm-3dof", "psm-wrist", "planar-2r"}) {
    const ToolRun run = run_tool({"stability", model, "--json", path("out.json"), "--quiet"});
    EXPECT_EQ(run.status, 0) << model << run.err;
    EXPECT_TRUE(json_of(path("out.json"))["largest_stable_stiffness"].is_number()) << model;
  }
  const ToolRun run = run_tool({"stability", "psm-3dof", "--frame", "elbow", "--pose", "0,0,0.1",
                                "--quiet"});
  EXPECT_EQ(run.status, 0) << run.err;
}

TEST_F(Analysis, NamesInvalidInput) {
  const std::string spring = example("two-arms-spring");
  const struct {
    std::vector<std::string> arguments;
    int status;
    const char* words;
  } cases[] = {
      {{"stability", spring, "--map", "stiffness=1:10:5"}, 2, "two ranges"},
      {{"stability", spring, "--locus", "gain=1:0:5"}, 2, "FROM below TO"},
      {{"stability", spring, "--set", "stifness=3"}, 2, "did you mean 'stiffness'"},
      {{"stability", spring, "--set", "delay=1e9"}, 3, "expected at most 1000 cycles"},
      {{"stability", spring, "--set", "stiffness=-1"}, 2, "above zero"},
      {{"stability", spring, "--frame", "tool"}, 3, "expected a MODEL"},
      {{"stability", "psm-3dof", "--pose", "0,0"}, 3, "start of 2 joints"},
      {{"stability", "psm-3dof", "--recommend", "40"}, 3, "no member"},
      {{"stability", "no-such-arm"}, 3, "no-such-arm"},
      {{"kinematics", "PSM1", "--forward=0.1"}, 2, "found 1 joints"},
      {{"kinematics", "PSM1", "--inverse=9,9,9,1,0,0,0", "--quiet"}, 4, ""},
  };
  for (const auto& one : cases) {
    const ToolRun run = run_tool(one.arguments);
    EXPECT_EQ(run.status, one.status) << one.arguments[1] << " " << one.words << run.err;
    EXPECT_NE(run.err.find(one.words), std::string::npos) << run.err;
  }
}

// Closed forms of the kit's arms, and Newton's steps: the pose that forward gives is taken back.
TEST_F(Analysis, InverseKinematicsInvertsForwardKinematics) {
  const struct {
    const char* arm;
    const char* joints;
  } cases[] = {{"PSM1", "0.3,-0.2,0.1,0.4,0.2,0.1"},
               {"ECM", "0.2,0.1,0.1,0.3"},
               {"MTMR", "0.2,0.3,-0.1,0.5,0.4,0.2,0.6"}};
  const auto tip_of = [&](const std::string& file) {
    std::istringstream rows(content_of(path(file)));
    std::string head, row, name, value;
    std::getline(rows, head);
    std::getline(rows, row);
    std::istringstream names(head), values(row);
    std::vector<double> out;
    while (std::getline(names, name, ',') && std::getline(values, value, ',')) {
      if (name == "x" || name == "y" || name == "z" || (name[0] == 'q' && name[1] > '9'))
        out.push_back(std::stod(value));
    }
    return out;
  };
  for (const auto& one : cases) {
    SCOPED_TRACE(one.arm);
    ASSERT_EQ(run_tool({"kinematics", one.arm, std::string("--forward=") + one.joints, "-o",
                        path("there.csv"), "--quiet"})
                  .status,
              0);
    const std::vector<double> there = tip_of("there.csv");
    ASSERT_EQ(there.size(), 7U);
    std::string pose;
    for (const double x : there) pose += (pose.empty() ? "" : ",") + std::to_string(x);
    for (const char* solver : {"closed-form", "newton"}) {
      const ToolRun run = run_tool({"kinematics", one.arm, "--inverse=" + pose, "--solver", solver,
                                    "-o", path("back.csv"), "--quiet"});
      ASSERT_EQ(run.status, 0) << solver << run.out << run.err;
      const std::vector<double> back = tip_of("back.csv");
      for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(back[i], there[i], 2e-6) << solver;
    }
  }
}

TEST_F(Analysis, StabilityAndKinematicsPagesRenderWithoutFaults) {
  if (browser().empty()) GTEST_SKIP() << "no browser: chromium is not installed";
  ASSERT_EQ(run_tool({"stability", example("two-arms-spring"), "--locus", "gain=0.05:20:12", "--map",
                      "stiffness=500:50000:8,delay=0:0.02:6", "--report", path("s.html"), "--quiet"})
                .status,
            0);
  ASSERT_EQ(run_tool({"kinematics", "PSM1", "--workspace", "200", "--report", path("k.html"), "--quiet"})
                .status,
            0);
  for (const OpenedPage& opened : open_pages({{path("s.html"), 1200}, {path("k.html"), 1200}})) expect_faultless(opened, 1200);
}

}  // namespace
}  // namespace veridyn
