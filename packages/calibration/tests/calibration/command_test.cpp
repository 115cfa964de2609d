#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cmath>

#include "cli/tool.hpp"
#include "simulated_capture.hpp"
#include "support/browser.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

std::string pose_csv(const PoseCapture& poses) {
  std::string out = "t";
  for (Eigen::Index i = 0; i < poses.q.cols(); ++i) out += fmt::format(",q{}", i + 1);
  out += ",x,y,z,qw,qx,qy,qz\n";
  for (int k = 0; k < poses.frames(); ++k) {
    const Eigen::Isometry3d& T = poses.poses[k];
    const Eigen::Quaterniond q(T.linear());
    out += fmt::format("{}", poses.time[k]);
    for (Eigen::Index i = 0; i < poses.q.cols(); ++i) out += fmt::format(",{:.10g}", poses.q(k, i));
    out += fmt::format(",{:.10g},{:.10g},{:.10g},{:.10g},{:.10g},{:.10g},{:.10g}\n",
                       T.translation().x(), T.translation().y(), T.translation().z(), q.w(), q.x(),
                       q.y(), q.z());
  }
  return out;
}

std::string marker_csv(const MarkerCapture& capture) {
  std::string out = "t";
  for (const CapturedMarker& m : capture.markers)
    for (const char* c : {"x", "y", "z"}) out += "," + m.body + "/" + m.name + "/" + c;
  out += "\n";
  for (Eigen::Index k = 0; k < capture.time.size(); ++k) {
    out += fmt::format("{}", capture.time[k]);
    for (const CapturedMarker& m : capture.markers)
      for (int c = 0; c < 3; ++c)
        out += std::isnan(m.position(c, k)) ? "," : fmt::format(",{:.8g}", m.position(c, k));
    out += "\n";
  }
  return out;
}

TEST(CalibrateCommand, AxisWritesAxesLinksAndAPage) {
  const TemporaryFolder folder;
  const MarkerCapture capture = captured_psm(read_model("psm-3dof"), 400, {}, 1);
  const std::string file = folder.write("markers.csv", marker_csv(capture));
  const ToolRun run = run_tool({"calibrate", "axis", file, "--json", folder.path("a.json"),
                                "--report", folder.path("a.html")});
  ASSERT_EQ(run.status, 0) << run.err;
  const nlohmann::json json = json_of(folder.path("a.json"));
  ASSERT_EQ(json["axes"].size(), 5U);
  EXPECT_EQ(json["axes"][0]["between"], (std::vector<std::string>{"base", "yaw"}));
  EXPECT_EQ(json["axes"][0]["direction"].size(), 3U);
  EXPECT_EQ(json["axes"][0]["point"].size(), 3U);
  EXPECT_LT(json["axes"][0]["interval_deg"], 0.1);
  EXPECT_LT(json["axes"][0]["interval_m"], 5e-4);
  ASSERT_EQ(json["links"].size(), 4U);
  EXPECT_NEAR(json["links"][2]["distance"].get<double>(), 0.516, 3e-4);
  EXPECT_NEAR(json["links"][2]["plane_parallel_distance"].get<double>(), 0.516, 3e-4);
  EXPECT_NEAR(json["links"][0]["twist_deg"].get<double>(), 90.0, 0.1);
  const OpenedPage page = open_page(folder.path("a.html"), 1200);
  expect_faultless(page, 1200);
}

TEST(CalibrateCommand, AxisReportsEveryRequestedPairOfAClosedLoop) {
  const TemporaryFolder folder;
  std::vector<std::string> arguments = {"calibrate", "axis",
                                        folder.write("ladder.csv", marker_csv(captured_ladder(2, 300, 1e-4))),
                                        "--json", folder.path("a.json")};
  for (const auto& [a, b] : ladder_pairs()) {
    arguments.emplace_back("--between");
    arguments.push_back(a + "," + b);
  }
  const ToolRun run = run_tool(arguments);
  ASSERT_EQ(run.status, 0) << run.err;
  const nlohmann::json json = json_of(folder.path("a.json"));
  ASSERT_EQ(json["axes"].size(), 7U);
  int closing = 0;
  for (const nlohmann::json& axis : json["axes"]) {
    closing += axis["closes_loop"].get<bool>() ? 1 : 0;
    EXPECT_EQ(axis["loop_play_m"].get<double>(), 0.0);
  }
  EXPECT_EQ(closing, 2);
  EXPECT_TRUE(json["cannot_tell"].empty());
  EXPECT_NE(run.out.find("closes a loop: it fits within the noise"), std::string::npos) << run.out;
  // The couplers do not turn against the yawing body: no axis, and that is the answer.
  arguments.insert(arguments.end(), {"--between", "yaw,coupler"});
  EXPECT_NE(run_tool(arguments).out.find("'yaw' and 'coupler': they turn by"), std::string::npos);
}

TEST(CalibrateCommand, RemoteCentreIsFoundAndBadPosesAreRefused) {
  const TemporaryFolder folder;
  std::vector<Eigen::Isometry3d> two;
  std::vector<Eigen::Isometry3d> one;
  const Eigen::Vector3d centre(0.1, 0.2, 0.3);
  const Eigen::Vector3d tip(0.0, 0.05, -0.3);
  for (int k = 0; k < 100; ++k) {
    for (std::vector<Eigen::Isometry3d>* poses : {&two, &one}) {
      Eigen::Isometry3d T(Eigen::AngleAxisd(0.6 * std::sin(0.3 * k), Eigen::Vector3d::UnitX()));
      if (poses == &two) T.rotate(Eigen::AngleAxisd(0.5 * std::cos(0.2 * k), Eigen::Vector3d::UnitY()));
      T.translation() = centre - T.linear() * tip;
      poses->push_back(T);
    }
  }
  const std::string good = folder.write("two.csv", pose_csv(capture_of(two)));
  const ToolRun run = run_tool({"calibrate", "rcm", good, "--json", folder.path("r.json")});
  ASSERT_EQ(run.status, 0) << run.err;
  const nlohmann::json json = json_of(folder.path("r.json"));
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(json["rcm"][c].get<double>(), centre[c], 1e-8);
    EXPECT_NEAR(json["tip"][c].get<double>(), tip[c], 1e-8);
    EXPECT_LT(json["rms"][c].get<double>(), 1e-8);
    EXPECT_EQ(json["interval"]["rcm"][c].size(), 2U);
  }
  const std::string bad = folder.write("one.csv", pose_csv(capture_of(one)));
  const ToolRun refused = run_tool({"calibrate", "rcm", bad, "--json", folder.path("no.json")});
  EXPECT_EQ(refused.status, 4);
  EXPECT_NE(refused.err.find("one axis only"), std::string::npos) << refused.err;
  EXPECT_EQ(refused.error_lines(), 1);
  EXPECT_EQ(run_tool({"calibrate", "rcm", folder.write("x.csv", "t,x\n0,a\n")}).status, 3);
  EXPECT_EQ(run_tool({"calibrate", "rcm"}).status, 2);
}

TEST(CalibrateCommand, LinksWritesARobotFileWithTheCorrectedConstant) {
  const TemporaryFolder folder;
  const Model truth = read_model("psm-3dof");
  const double beta = truth.description().constants.at("beta");
  ModelFileOptions wrong;
  wrong.constants["beta"] = beta + M_PI / 180.0;
  save_model(read_model("psm-3dof", wrong), folder.path("wrong.yaml"));
  const std::string poses =
      folder.write("poses.csv", pose_csv(captured_poses(truth, "tool", 120, 0.9, 1e-4, 1e-3, 3)));
  const ToolRun run =
      run_tool({"calibrate", "links", folder.path("wrong.yaml"), poses, "--frame", "tool", "--json",
                folder.path("l.json"), "--robot-out", folder.path("right.yaml"), "--report",
                folder.path("l.html")});
  ASSERT_EQ(run.status, 0) << run.err;
  const nlohmann::json json = json_of(folder.path("l.json"));
  bool found = false;
  for (const nlohmann::json& c : json["constants"]) {
    if (c["name"] != "beta") continue;
    found = true;
    EXPECT_NEAR(c["file"].get<double>(), beta + M_PI / 180.0, 1e-12);
    EXPECT_NEAR(c["found"].get<double>(), beta, 1e-3);
    EXPECT_LE(c["interval"][0].get<double>(), beta);
    EXPECT_GE(c["interval"][1].get<double>(), beta);
    EXPECT_TRUE(c["identifiable"].get<bool>());
  }
  EXPECT_TRUE(found);
  EXPECT_LT(json["held_out_rms"].get<double>(), 3e-4);
  const Model right = read_model(folder.path("right.yaml"));
  EXPECT_NEAR(right.description().constants.at("beta"), beta, 1e-3);
  expect_faultless(open_page(folder.path("l.html"), 1200), 1200);
  EXPECT_EQ(run_tool({"calibrate", "links", "psm-3dof", poses, "--frame", "nose"}).status, 2);
  EXPECT_EQ(run_tool({"calibrate", "links", "ur10e", poses}).status, 3);
}

// The wrong constant from torques and the one from poses, in one line.
TEST(CalibrateCommand, LinksReportsWhetherADiagnosisAndThePosesAgree) {
  const TemporaryFolder folder;
  const std::string poses = folder.write(
      "poses.csv",
      pose_csv(captured_poses(read_model("psm-3dof"), "counterweight", 100, 0.9, 1e-4, 1e-3, 5)));
  const auto said = [&](const std::string& findings) {
    const std::string file = folder.write("d.json", R"({"findings": [)" + findings + "]}");
    return run_tool({"calibrate", "links", "psm-3dof-printed", poses, "--frame", "counterweight",
                     "--diagnosis", file, "--quiet"});
  };
  const std::string constant =
      R"({"effect": "coupling_error", "frame": "counterweight_rail", "constant": "theta",)"
      R"("parameters": {"value": {"value": -1.5637, "ci95": [-1.634, -1.4934]}}})";
  EXPECT_NE(said(constant).out.find("-89.9"), std::string::npos);
  EXPECT_NE(said(constant).out.find("they agree."), std::string::npos) << said(constant).out;
  const std::string zero = R"({"effect": "encoder_offset", "coordinate": "pitch"})";
  EXPECT_NE(said(zero).out.find("a zero (encoder_offset:pitch)"), std::string::npos);
  EXPECT_NE(said(zero).out.find("poses theta of frame counterweight_rail"), std::string::npos)
      << said(zero).out;
  EXPECT_NE(said("").out.find("Torques ask for no other constant."), std::string::npos);
  const ToolRun bad = said(R"({"effect": "coupling_error", "constant": "a"})");
  EXPECT_EQ(bad.status, 3) << bad.err;
  EXPECT_EQ(bad.error_lines(), 1) << bad.err;
}

TEST(CalibrateCommand, HandEyeFindsTheTransformOfTwoArms) {
  const TemporaryFolder folder;
  RandomNumbers random(2);
  const Eigen::Isometry3d T = random_pose(random, 0.4);
  std::vector<Eigen::Isometry3d> a;
  std::vector<Eigen::Isometry3d> b;
  for (int k = 0; k < 30; ++k) {
    a.push_back(random_pose(random, 0.2));
    b.push_back(T.inverse() * a.back());
  }
  const ToolRun run = run_tool({"calibrate", "handeye",
                                folder.write("A.csv", pose_csv(capture_of(a))),
                                folder.write("B.csv", pose_csv(capture_of(b))), "--json",
                                folder.path("h.json")});
  ASSERT_EQ(run.status, 0) << run.err;
  const nlohmann::json json = json_of(folder.path("h.json"))["transform"];
  Eigen::Quaterniond q(json["quaternion"][0], json["quaternion"][1], json["quaternion"][2],
                       json["quaternion"][3]);
  EXPECT_LT(q.angularDistance(Eigen::Quaterniond(T.linear())), 1e-6);
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(json["translation"][c].get<double>(), T.translation()[c], 1e-7);
  EXPECT_TRUE(json["interval_m"].is_number());
  EXPECT_TRUE(json["interval_deg"].is_number());
  const std::string two = folder.write("two.csv", pose_csv(capture_of({a[0], a[1]})));
  EXPECT_EQ(run_tool({"calibrate", "handeye", two, two}).status, 4);
}

TEST(CalibrateCommand, ExciteWritesPosesWithinTheLimits) {
  const TemporaryFolder folder;
  const ToolRun run = run_tool({"excite", "psm-3dof", "--for", "calibration", "--poses", "12",
                                "--frame", "tool", "-o", folder.path("poses.csv")});
  ASSERT_EQ(run.status, 0) << run.err;
  const std::string csv = content_of(folder.path("poses.csv"));
  EXPECT_EQ(csv.substr(0, csv.find('\n')), "t,q1,q2,q3");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 13);
  EXPECT_EQ(run_tool({"excite", "psm-3dof", "--for", "calibration", "--harmonics", "3", "-o",
                      folder.path("no.csv")}).status, 2);
}

}  // namespace
}  // namespace veridyn
