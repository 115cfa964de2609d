#include "report/pages/simulation_page.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "support/browser.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

using nlohmann::json;

constexpr Eigen::Index kRows = 1500;
constexpr double kStep = 0.01;

class SimulationPage : public testing::Test {
 protected:
  void SetUp() override {
    if (browser().empty()) GTEST_SKIP() << "no browser: chromium is not installed";
  }

  // Opens a page as a reader on a wide and on a narrow screen does.
  static OpenedPage open(const std::string& page, int width = 900) {
    const std::filesystem::path path =
        std::filesystem::temp_directory_path() /
        (std::string("veridyn-simulation-") +
         testing::UnitTest::GetInstance()->current_test_info()->name() + ".html");
    std::ofstream(path) << page;
    OpenedPage opened = open_page(path.string(), width);
    std::filesystem::remove(path);
    expect_faultless(opened, width);
    const json result = embedded(opened.html, "result");
    for (const PageElement& n : opened.with("data-from")) expect_number(n, result);
    return opened;
  }
};

ReplayInput waves() {
  ReplayInput in;
  in.motion.time = VectorXd::LinSpaced(kRows, 0.0, kStep * (kRows - 1));
  in.motion.q = MatrixXd(kRows, 2);
  in.tau = in.motion.q;
  for (Eigen::Index k = 0; k < kRows; ++k) {
    for (int i = 0; i < 2; ++i) {
      in.motion.q(k, i) = 0.5 * std::sin((1.0 + i) * in.motion.time[k]);
      in.tau(k, i) = 3.0 * std::cos((1.0 + i) * in.motion.time[k]);
    }
  }
  in.motion.dq = in.motion.ddq = in.motion.q;
  in.use.assign(kRows, 1);
  std::fill(in.use.begin(), in.use.begin() + 100, 0);
  return in;
}

// A run that ended before the recording did.
Replay stopped_replay(const ReplayInput& in, Eigen::Index rows) {
  Replay r;
  r.run.motion = {in.motion.time.head(rows), in.motion.q.topRows(rows), in.motion.dq.topRows(rows),
                  in.motion.ddq.topRows(rows)};
  r.run.motion.q.array() += 1e-3;
  r.run.tau = in.tau.topRows(rows);
  r.run.status = StepStatus::kNotFinite;
  r.run.stopped_at = 7.25;
  r.run.joint = JointIndex{1};
  r.gains.p = r.gains.i = r.gains.d = VectorXd::Ones(2);
  r.torque_error = VectorXd::Constant(2, 0.0321);
  r.inverse_error = VectorXd::Constant(2, 0.0287);
  r.motion_rms = VectorXd::Constant(2, 1.1e-3);
  r.motion_max = VectorXd::Constant(2, 4.5e-3);
  r.recorded_tau = in.tau.topRows(rows);
  r.simulated_tau = 1.05 * r.recorded_tau;
  r.predicted_tau = 0.97 * r.recorded_tau;
  r.use.assign(in.use.begin(), in.use.begin() + rows);
  return r;
}

TEST_F(SimulationPage, AReplayShowsMotionTorqueAndResidual) {
  const Model arm = read_model("planar-2r");
  const ReplayInput in = waves();
  const std::string page =
      to_page(stopped_replay(in, 800), arm, in, {"rec.csv", "veridyn simulate", "text"});
  for (const int width : {900, 380}) {
    const OpenedPage opened = open(page, width);
    int plots = 0;
    for (const PageElement& plot : opened.with("data-plot")) {
      if (plot.at("data-plot") != "time" && plot.at("data-plot") != "error") continue;
      std::map<std::string, long> points = counts(plot.at("data-points"));
      // Rows that are left out of the errors are not drawn among the torques.
      EXPECT_GE(points["simulated"], 700) << plot.at("data-points");
      ++plots;
    }
    EXPECT_EQ(plots, 8);  // two joints: position, torque, and the difference of either
  }
  const std::string words = open(page).html;
  EXPECT_NE(without_scripts(words).find("Incomplete: the run stopped at 7.25 s: joint"),
            std::string::npos);
}

TEST_F(SimulationPage, ABreakawayShowsRecordedAndSimulatedCurves) {
  const Model arm = read_model("psm-3dof");
  ReplayInput in;
  in.motion.time = VectorXd::LinSpaced(kRows, 0.0, kStep * (kRows - 1));
  in.motion.q = in.tau = MatrixXd::Zero(kRows, 3);
  Breakaway found;
  found.joint = {2};
  found.speed = 5e-3;
  found.simulated_q = VectorXd::Constant(kRows, NAN);
  for (Eigen::Index k = 0; k < kRows; ++k) {
    const double t = in.motion.time[k];
    const double side = t < 7.5 ? 1.0 : -1.0;
    const double of_ramp = t < 7.5 ? t : t - 7.5;
    in.tau(k, 2) = side * 0.1 * of_ramp;
    in.motion.q(k, 2) = side * 1e-4 * std::exp(of_ramp - 5.0);
    if (of_ramp < 5.5) found.simulated_q[k] = 1.2 * in.motion.q(k, 2);
  }
  found.events = {{0.0, 1, 6.0, 0.6, 5.5, 0.55}, {7.5, -1, 13.5, -0.6, 0.0, NAN}};
  found.recorded_forward = 0.6;
  found.simulated_forward = 0.55;
  found.recorded_backward = -0.6;
  found.simulated_backward = NAN;  // the model did not move
  const OpenedPage opened =
      open(to_page(found, arm, in, {"ramps.csv", "veridyn simulate", "text"}));
  const std::vector<PageElement> plots = opened.with("data-plot");
  ASSERT_EQ(plots.size(), 2u);
  for (const PageElement& plot : plots) {
    std::map<std::string, long> points = counts(plot.at("data-points"));
    EXPECT_GT(points["recorded"], 100);
    EXPECT_GT(points["simulated"], 100);
  }
}

}  // namespace
}  // namespace veridyn
