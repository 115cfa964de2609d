#include <gtest/gtest.h>

#include <cmath>
#include <iomanip>
#include <sstream>

#include "cli/tool.hpp"
#include "dvrk/gravity_support.hpp"
#include "dvrk/arms/arm_facts.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

std::string digits(double value) {
  std::ostringstream out;
  out << std::setprecision(17) << value;
  return out.str();
}

// A PSM whose bodies have values, as a file.
std::string psm_file(const TemporaryFolder& folder, Model* arm = nullptr) {
  ModelDescription description = with_random_bodies(read_model("psm-3dof"), 8).description();
  description.coordinates[0].recorded.torque_gain = 1.25;
  const Model model(description);
  const std::string path = folder.path("model.yaml");
  save_model(model, path);
  if (arm != nullptr) *arm = model;
  return path;
}

TEST(ExportDvrk, GravityRowsHaveTheModelsTorques) {
  const TemporaryFolder folder;
  Model arm = read_model("psm-3dof");
  const std::string model = psm_file(folder, &arm);
  const ToolRun run = run_tool({"export", model, "--dvrk-gravity", folder.path("g.json")});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("PSM1: gravity of the model in 6 rows"), std::string::npos) << run.out;
  const nlohmann::json file = json_of(folder.path("g.json"));
  Random random(9);
  for (int trial = 0; trial < 10; ++trial) {
    const VectorXd q = random.vector(3, 0.01, 0.24);
    const VectorXd rest = VectorXd::Zero(3);
    const VectorXd tau = inverse_dynamics(arm, q, rest, rest);
    const std::vector<double> joints{q[0], q[1], q[2], 0.3, 0.2, 0.1};
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(gravity_by_differences(file, joints, k, 9.81), tau[static_cast<int>(k)],
                  1e-7 * (1.0 + tau.norm()));
    }
  }
}

// Measured efforts equal to the model's have no difference; half a newton metre more is reported.
TEST(ExportDvrk, RowsAreComparedWithTheRestingArm) {
  const TemporaryFolder folder;
  Model arm = read_model("psm-3dof");
  const std::string model = psm_file(folder, &arm);
  std::string csv = "q1,q2,q3,tau1,tau2,tau3\n";
  Random random(10);
  for (int trial = 0; trial < 25; ++trial) {
    const VectorXd q = random.vector(3, 0.01, 0.24);
    const VectorXd rest = VectorXd::Zero(3);
    const VectorXd tau = inverse_dynamics(arm, q, rest, rest);
    csv += digits(q[0]) + "," + digits(q[1]) + "," + digits(q[2]) + "," + digits(tau[0]) + "," +
           digits(tau[1] + 0.5) + "," + digits(tau[2]) + "\n";
  }
  const ToolRun run = run_tool({"export", model, "--dvrk-gravity", folder.path("g.json"),
                                "--static-torques", folder.write("rest.csv", csv)});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("25 samples at rest"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("without gravity 0.5 N m"), std::string::npos) << run.out;
}

TEST(ExportDvrk, ScalesMultiplyTheCurrentScalesOfTheConfiguration) {
  const TemporaryFolder folder;
  const std::string config =
      std::string(VERIDYN_SOURCE_DIR) + "/data/dvrk/sawRobotIO1394-PSM1-example.xml";
  const ToolRun run = run_tool({"export", psm_file(folder), "--dvrk-scales", folder.path("s.json"),
                                "--dvrk-config", config});
  ASSERT_EQ(run.status, 0) << run.err;
  const nlohmann::json file = json_of(folder.path("s.json"));
  const auto& actuators = file.at("robots").at(0).at("actuators");
  ASSERT_EQ(actuators.size(), 7U);
  EXPECT_NEAR(actuators.at(0).at("drive").at("effort_to_current").at("scale").get<double>(),
              1.25 * 0.4040893846, 1e-12);
  EXPECT_NEAR(actuators.at(1).at("drive").at("effort_to_current").at("scale").get<double>(),
              0.4040893846, 1e-12);
  EXPECT_NE(run.out.find("torque gain of yaw"), std::string::npos) << run.out;
}

TEST(ExportDvrk, BadInputAndWrongUsageAreReported) {
  const TemporaryFolder folder;
  const std::string model = psm_file(folder);
  const std::string out = folder.path("g.json");
  const auto fails = [&](const Words& words, int status, const std::string& said) {
    const ToolRun run = run_tool(Words{"export"} + words);
    EXPECT_EQ(run.status, status) << run.err;
    EXPECT_NE(run.err.find(said), std::string::npos) << run.err;
    EXPECT_EQ(run.error_lines(), 1) << run.err;
  };
  fails({"psm-3dof", "--dvrk-gravity", out}, 3, "without values");
  fails({"ur10e", "--dvrk-gravity", out}, 3, "--dvrk-arm");
  fails({model, "--dvrk-gravity", out, "--dvrk-arm", "PSM7"}, 2, "did you mean");
  fails({model, "--dvrk-gravity", out, "--dvrk-arm", "MTML"}, 3, "expected a PSM or ECM");
  const std::string broken = folder.write("io.xml", "<Config Version=\"5\">\n<Robot/>\n</Config>");
  fails({model, "--dvrk-scales", out, "--dvrk-config", broken}, 3, "io.xml:2: Robot");
  fails({model, "--dvrk-gravity", out, "--static-torques", folder.write("r.csv", "1,2,3\n")}, 3,
        "r.csv:1");
  EXPECT_EQ(run_tool({"export", model, "--dvrk-gravity", out, "--dvrk-scales", out}).status, 2);
  EXPECT_EQ(run_tool({"export", model, "--yaml", out, "--dvrk-config", broken}).status, 2);
  EXPECT_EQ(run_tool({"export", model, "--yaml", out, "--dvrk-arm", "PSM1"}).status, 2);
}

}  // namespace
}  // namespace veridyn
