#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "cli/tool.hpp"

// The file of a simulation as ROBOT: a stranger's arm, its recordings, and the values back in its file.

namespace veridyn {
namespace {

const char* const kMjcf = R"(<mujoco model="two links">
  <compiler angle="degree"/>
  <default><geom rgba="0.2 0.4 0.6 1"/></default>
  <worldbody>
    <body name="upper" pos="0 0 1">
      <joint name="shoulder" axis="0 1 0" range="-120 120" damping="DAMPING" frictionloss="0.4"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.03" mass="2"/>
      <body name="fore" pos="0 0 -0.5">
        <joint name="elbow" axis="0 1 0" range="-120 120" damping="0.3" frictionloss="0.2"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.025" mass="1.2"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor name="s" joint="shoulder" forcerange="-60 60"/><motor name="e" joint="elbow" forcerange="-30 30"/></actuator>
</mujoco>
)";

std::string mjcf(const std::string& damping) {
  std::string out = kMjcf;
  return out.replace(out.find("DAMPING"), 7, damping);
}

// Two joints that swing with three frequencies each, 100 Hz for 20 s.
std::string trajectory(double phase) {
  std::string out = "t,q1,q2\n";
  for (int k = 0; k <= 2000; ++k) {
    const double t = 0.01 * k;
    out += std::to_string(t);
    for (int i = 0; i < 2; ++i) {
      double q = 0.0;
      for (int h = 1; h <= 3; ++h) q += 0.5 / h * std::sin((0.6 + 0.25 * i) * h * M_PI * t + phase * h + i);
      out += "," + std::to_string(q);
    }
    out += "\n";
  }
  return out;
}

// One line on standard error that begins with the file and its line.
void expect_refused(const ToolRun& run, const std::string& begin) {
  EXPECT_EQ(run.status, 3) << run.err;
  EXPECT_EQ(run.error_lines(), 1) << run.err;
  EXPECT_NE(run.err.find(begin), std::string::npos) << run.err;
}

TEST(SimulationFileAsRobot, DiagnosedValuesAreWrittenBackIntoTheFile) {
  const TemporaryFolder folder;
  const std::string sim = folder.write("sim.xml", mjcf("0.5"));
  const std::string real = folder.write("real.xml", mjcf("2.5"));  // what the simulation does not know
  EXPECT_EQ(run_tool({"info", sim}).status, 0);
  for (const char* seed : {"1", "2"}) {
    const std::string motion = folder.write("motion.csv", trajectory(std::stod(seed)));
    const ToolRun run = run_tool({"simulate", real, "--trajectory", motion, "--seed", seed, "-o", folder.path(std::string(seed) + ".csv"), "--quiet"});
    ASSERT_EQ(run.status, 0) << run.err;
  }
  const std::string one = folder.path("1.csv"), two = folder.path("2.csv");
  EXPECT_EQ(run_tool({"check", sim, one}).status, 0);
  const std::string model = folder.path("model.yaml");
  const ToolRun found = run_tool({"diagnose", sim, "--values", "facts", "--train", one, "--test", two, "--model-out", model, "--json", folder.path("d.json")});
  ASSERT_EQ(found.status, 0) << found.err;
  EXPECT_NE(found.out.find("viscous friction changed from 0.5 to 2.5"), std::string::npos) << found.out;
  const std::string fresh = folder.path("new.xml");
  const ToolRun written = run_tool({"export", model, "--mjcf", fresh});
  ASSERT_EQ(written.status, 0) << written.err;
  EXPECT_NE(written.err.find("damping of shoulder"), std::string::npos) << written.err;
  const std::string text = content_of(fresh);
  EXPECT_NE(text.find("fromto=\"0 0 0 0 0 -0.5\""), std::string::npos);
  EXPECT_NE(text.find("rgba=\"0.2 0.4 0.6 1\""), std::string::npos);
  EXPECT_EQ(text.find("<inertial"), std::string::npos) << "the bodies were right";
  const ToolRun again = run_tool({"diagnose", fresh, "--values", "facts", "--train", one, "--test", two});
  EXPECT_EQ(again.out.find("viscous friction changed"), std::string::npos) << again.out;
  EXPECT_EQ(run_tool({"compare", fresh, real}).status, 0);
  // In one command: --model-out takes the simulation's own format.
  const std::string direct = folder.path("direct.xml");
  const ToolRun one_step = run_tool({"diagnose", sim, "--values", "facts", "--train", one, "--test", two, "--model-out", direct});
  ASSERT_EQ(one_step.status, 0) << one_step.err;
  EXPECT_EQ(content_of(direct), text);
  const std::string identified = folder.path("identified.xml");
  ASSERT_EQ(run_tool({"identify", sim, "--train", one, "--model-out", identified, "--quiet"}).status, 0);
  EXPECT_EQ(run_tool({"info", identified}).status, 0);
  for (const char* wrong : {"direct.sdf", "direct.mjcf.json"})
    EXPECT_EQ(run_tool({"diagnose", sim, "--train", one, "--test", two, "--model-out", folder.path(wrong)}).status, 2) << wrong;
  EXPECT_EQ(run_tool({"identify", "planar-2r", "--train", one, "--model-out", folder.path("no.xml")}).status, 2);
}

TEST(SimulationFileAsRobot, IsIdentifiedAndExportedAsSdf) {
  const TemporaryFolder folder;
  const std::string sim = folder.write("sim.xml", mjcf("0.5"));
  const std::string rows = folder.path("rows.csv");
  ASSERT_EQ(run_tool({"simulate", sim, "--trajectory", folder.write("motion.csv", trajectory(1.0)), "-o", rows, "--quiet"}).status, 0);
  const std::string model = folder.path("m.yaml");
  const ToolRun run = run_tool({"identify", sim, "--train", rows, "--model-out", model, "--quiet"});
  ASSERT_EQ(run.status, 0) << run.err;
  const std::string sdf = folder.path("m.sdf");
  ASSERT_EQ(run_tool({"export", model, "--sdf", sdf, "--quiet"}).status, 0);
  EXPECT_EQ(run_tool({"info", sdf}).status, 0);
}

TEST(SimulationFileAsRobot, BadInputIsReportedInOneLine) {
  const TemporaryFolder folder;
  const std::string bad = folder.write("bad.xml", mjcf("much"));
  expect_refused(run_tool({"info", bad}), bad + ":6:7: found damping 'much', expected finite numbers.");
  expect_refused(run_tool({"info", folder.path("none.xml")}), "none.xml: found no such file");
  expect_refused(run_tool({"info", folder.path("none.sdf")}), "none.sdf: found no such file");
  const std::string sim = folder.write("sim.xml", mjcf("0.5"));
  EXPECT_EQ(run_tool({"export", sim, "--sdf", folder.path("x.sdf"), "--into", sim}).status, 2);
  EXPECT_EQ(run_tool({"export", sim, "--mjcf", folder.path("x.xml"), "--into", folder.path("none.mjcf")}).status, 3);
  EXPECT_EQ(folder.files().size(), 2U);  // nothing was written
}

}  // namespace
}  // namespace veridyn
