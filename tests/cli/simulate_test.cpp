#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "cli/tool.hpp"

// `veridyn simulate` with a controller, a replay and ramps.

namespace veridyn {
namespace {

using nlohmann::json;

class Simulate : public testing::Test {
 protected:
  // A slow motion of planar-2r.
  std::string trajectory() const { return folder_.write("traj.csv", planar_recording(6.0)); }

  TemporaryFolder folder_;
};

TEST_F(Simulate, AReplayHasTheTorquesOfItsRecordingWithinTenPercent) {
  const std::string recording = folder_.path("rec.csv");
  const std::string model = folder_.path("model.yaml");
  const std::string out = folder_.path("out.json");
  ToolRun run =
      run_tool({"simulate", "planar-2r", "--trajectory", trajectory(), "--controller", "pid", "-o",
                recording, "--noise", "none", "--model-out", model, "--json", out, "--quiet"});
  ASSERT_EQ(run.status, 0) << run.err;
  const json made = json_of(out);
  EXPECT_TRUE(made["complete"].get<bool>());
  for (const json& deviation : made["largest_deviation"]) {
    EXPECT_GT(deviation.get<double>(), 1e-6);  // a controller never follows exactly
    EXPECT_LT(deviation.get<double>(), 0.2);
  }
  run = run_tool({"simulate", model, "--replay", recording, "--json", out, "--quiet"});
  ASSERT_EQ(run.status, 0) << run.err;
  const json replayed = json_of(out);
  for (const json& error : replayed["torque"]["relative_error"])
    EXPECT_LT(error.get<double>(), 0.1);
}

TEST_F(Simulate, HasTheRequestedRateStaleRowsAndDropouts) {
  const std::string recording = folder_.path("rec.csv");
  const std::string out = folder_.path("check.json");
  for (const std::string controller : {"none", "pid"}) {
    const ToolRun run = run_tool({"simulate", "planar-2r", "--trajectory", trajectory(), "-o",
                                  recording, "--controller", controller, "--sample-rate", "137",
                                  "--noise", "dvrk-late:dropouts=0.02,dropout_run=5", "--quiet"});
    ASSERT_EQ(run.status, 0) << run.err;
    ASSERT_EQ(run_tool({"check", recording, "--json", out, "--quiet"}).status, 0);
    const std::string found = json_of(out).dump();
    EXPECT_NE(found.find("stale_rows"), std::string::npos) << found;
    EXPECT_NE(found.find("gaps"), std::string::npos) << found;
    EXPECT_NE(found.find("137"), std::string::npos) << found;
  }
}

TEST_F(Simulate, VeridynAndMujocoNeedTheSameRmsEffort) {
  std::vector<std::string> files;
  for (const std::string engine : {"veridyn", "mujoco"}) {
    files.push_back(folder_.path(engine + ".json"));
    const ToolRun run =
        run_tool({"simulate", "planar-2r", "--trajectory", trajectory(), "--controller", "pid",
                  "--engine", engine, "-o", folder_.path("rec.csv"), "--noise", "none", "--json",
                  files.back(), "--quiet"});
    if (run.status != 0 && engine == "mujoco") GTEST_SKIP() << run.err;
    ASSERT_EQ(run.status, 0) << run.err;
  }
  const json ours = json_of(files[0])["rms_effort"];
  const json theirs = json_of(files[1])["rms_effort"];
  for (size_t i = 0; i < ours.size(); ++i)
    EXPECT_NEAR(ours[i].get<double>(), theirs[i].get<double>(), 1e-3 * ours[i].get<double>());
}

TEST_F(Simulate, UsageErrorsAreOneLine) {
  const std::string traj = trajectory();
  const std::string rec = folder_.path("rec.csv");
  const std::vector<Words> wrong_usage = {
      {"--trajectory", traj},
      {"-o", rec},
      {"--trajectory", traj, "--replay", traj, "-o", rec},
      {"--trajectory", traj, "-o", rec, "--controller", "pi"},
      {"--trajectory", traj, "-o", rec, "--controller", "pid", "--kd", "1,1"},
      {"--trajectory", traj, "-o", rec, "--breakaway", "elbow"},
      {"--trajectory", traj, "-o", rec, "--noise", "dvrk:stale=0.1"},
      {"--trajectory", traj, "-o", rec, "--sample-rate", "0"},
      {"--trajectory", traj, "-o", rec, "--report", folder_.path("page.html")},
      {"--trajectory", traj, "-o", rec, "--controller", "pid", "--engine", "bullet"}};
  for (const Words& words : wrong_usage) {
    const ToolRun run = run_tool(Words{"simulate", "planar-2r"} + words);
    EXPECT_EQ(run.status, 2) << run.err;
    EXPECT_EQ(run.error_lines(), 1) << run.err;
  }
  const ToolRun gains = run_tool({"simulate", "planar-2r", "--trajectory", traj, "-o", rec,
                                  "--controller", "pid", "--kp", "1,2,3", "--quiet"});
  EXPECT_EQ(gains.status, 2);
  EXPECT_NE(gains.err.find("--kp: found 3 numbers, expected 2"), std::string::npos) << gains.err;
  EXPECT_FALSE(std::filesystem::exists(rec));
}

// A controller whose gains are far too high for its rate makes the arm fly apart, and one that sees
// the arm too late makes it run away.
TEST_F(Simulate, ARunThatFailsWritesNothing) {
  const std::string traj = trajectory();
  const Words files = folder_.files();
  const Words base = {"simulate",     "planar-2r",
                      "--trajectory", traj,
                      "-o",           folder_.path("rec.csv"),
                      "--controller", "pid",
                      "--noise",      "none",
                      "--json",       folder_.path("out.json"),
                      "--model-out",  folder_.path("truth.yaml"),
                      "--quiet"};
  for (const Words& wild :
       {Words{"--kp", "1e9,1e9", "--kd", "1e7,1e7", "--torque-limit", "1e300,1e300"},
        Words{"--encoder-delay", "0.5", "--torque-limit", "1e4,1e4"}}) {
    const ToolRun run = run_tool(base + wild);
    EXPECT_EQ(run.status, 4) << run.err;
    EXPECT_EQ(run.error_lines(), 1) << run.err;
    EXPECT_EQ(run.out, "");
    EXPECT_NE(run.err.find("the run stopped at"), std::string::npos) << run.err;
    EXPECT_EQ(folder_.files(), files);
  }
}

std::string real_data(const std::string& name) {
  const char* named = std::getenv("VERIDYN_REAL_DATA");
  const std::string folder =
      named != nullptr ? named : std::string(VERIDYN_SOURCE_DIR) + "/../shared/data";
  return folder + "/psm1-thesis/" + name;
}

// The extended model of fourier-1 to 4, run on the real arm's fifth motion and ramps.
TEST_F(Simulate, AnExtendedModelReplaysTheRealRecording) {
  if (!std::filesystem::exists(real_data("fourier-5.csv"))) GTEST_SKIP() << "no real recordings";
  const std::string model = folder_.path("model.yaml");
  const std::string out = folder_.path("out.json");
  const std::string page = folder_.path("page.html");
  ASSERT_EQ(run_tool({"diagnose", "psm-3dof", "--train", real_data("fourier-1.csv"),
                      real_data("fourier-2.csv"), real_data("fourier-3.csv"),
                      real_data("fourier-4.csv"), "--test", real_data("fourier-5.csv"),
                      "--model-out", model, "--json", out, "--quiet"})
                .status,
            0);
  const json held_out = json_of(out)["extended"]["test"]["relative_error"];
  for (const Words& gains : {Words{}, Words{"--kp", "200,200,600"}}) {
    const ToolRun run = run_tool(Words{"simulate", model, "--replay", real_data("fourier-5.csv"),
                                       "--json", out, "--report", page, "--quiet"} +
                                 gains);
    ASSERT_EQ(run.status, 0) << run.err;
    const json torque = json_of(out)["torque"]["relative_error"];
    for (size_t i = 0; i < 3; ++i)
      EXPECT_LT(torque[i].get<double>(), 1.3 * held_out[i].get<double>()) << i;
  }
  EXPECT_GT(std::filesystem::file_size(page), 100000u);
  const ToolRun run = run_tool({"simulate", model, "--replay", real_data("force-ramp.csv"),
                                "--breakaway", "insertion", "--json", out, "--quiet"});
  ASSERT_EQ(run.status, 0) << run.err;
  const json ramps = json_of(out);
  EXPECT_GT(ramps["ramps"].size(), 20u);
  EXPECT_NEAR(ramps["forward"]["recorded"].get<double>(), 0.43, 0.04);
  EXPECT_NEAR(ramps["backward"]["recorded"].get<double>(), -0.61, 0.04);
  // Friction behind a gap of 4 mm is not there yet when the joint breaks away.
  for (const char* side : {"forward", "backward"}) {
    const double recorded = ramps[side]["recorded"].get<double>();
    EXPECT_NEAR(ramps[side]["simulated"].get<double>(), recorded, 0.5 * std::abs(recorded)) << side;
  }
}

TEST(SimulateTrajectory, BeyondTheLimitsOrInOtherUnitsIsWarnedOf) {
  const TemporaryFolder folder;
  const auto said = [&](double scale_q, double scale_t) {
    std::string csv = "t,q1,q2,dq1,dq2\n";
    for (int k = 0; k < 1000; ++k) {
      const double t = 0.01 * k;
      for (const double number : {scale_t * t, scale_q * std::sin(2.0 * t), scale_q * std::cos(t), 2.0 * std::cos(2.0 * t)}) csv += std::to_string(number) + ",";
      csv += std::to_string(-std::sin(t)) + "\n";
    }
    const ToolRun run = run_tool({"simulate", "planar-2r", "--trajectory", folder.write("m.csv", csv), "-o", folder.path("r.csv"), "--quiet"});
    EXPECT_EQ(run.status, 0) << run.err;
    return run.err;
  };
  EXPECT_EQ(said(1.0, 1.0).find("warning"), std::string::npos);
  const std::string degrees = said(180.0 / M_PI, 1.0), milliseconds = said(1.0, 1000.0);
  EXPECT_NE(degrees.find("the motion is far beyond the limits of planar-2r: shoulder goes from -57.3 to 57.3 rad (limits -2.5 to 2.5)"), std::string::npos) << degrees;
  EXPECT_NE(degrees.find("warning", degrees.find("warning") + 1), std::string::npos) << degrees;
  EXPECT_NE(milliseconds.find("the times are no seconds.\n"), std::string::npos) << milliseconds;
}

// Figure 7.3 of the thesis, with its gains: friction that the law does not know keeps joints off, and
// compensation brings them back.
TEST(SimulateSteps, ComputedTorqueAcceptsUserGains) {
  const TemporaryFolder folder;
  const auto left = [&](const Words& more) {
    const ToolRun done =
        run_tool(Words{"simulate", "psm-3dof", "--controller", "computed-torque", "--steps",
                       "0.05,0.05,0.005", "--kp", "25,20,75", "--kd", "10,11,15", "--noise", "none",
                       "-o", folder.path("steps.csv"), "--quiet"} +
                 more);
    EXPECT_EQ(done.status, 0) << done.err;
    const size_t at = done.out.find("(insertion): at most ");
    EXPECT_NE(at, std::string::npos) << done.out;
    return std::stod(done.out.substr(at + 21));
  };
  const double alone = left({}), with = left({"--friction-share", "0.9"});
  EXPECT_GT(alone, 0.1);
  EXPECT_LT(with, 0.8 * alone);
  const ToolRun other =
      run_tool({"simulate", "psm-3dof", "--steps", "0.05,0.05,0.005", "-o", folder.path("s.csv")});
  EXPECT_EQ(other.status, 2);
}

}  // namespace
}  // namespace veridyn
