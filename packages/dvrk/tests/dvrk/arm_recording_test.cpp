#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

#include "dvrk/planar_run.hpp"
#include "dvrk/run/arm_run.hpp"

// Recordings of runs and of reading without motion.

namespace veridyn::dvrk {
namespace {

class ArmRecording : public PlanarRun {};

std::string first_line(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

TEST_F(ArmRecording, FollowsAMotionAndRecordsTheActingTorques) {
  ArmSession arm(link_, planar_config());
  const MotionSamples wanted = motion(8.0);
  const RunResult run = run_motion(arm, link_, wanted, sensible_gains(model_), RunOptions(), stop_);
  ASSERT_TRUE(run.complete) << run.why << "\n" << arm.boards().faults().report();
  EXPECT_EQ(arm.boards().faults().report(), "");
  EXPECT_NEAR(run.rows.rows(), 8.0 * 1500, 20);
  EXPECT_EQ(run.timing.late, 0);
  double worst = 0.0;
  for (int k = 0; k < run.rows.rows(); ++k) {
    const double w = 2.0 * M_PI * 2 / 8.0;
    worst = std::max(
        worst, std::abs(run.rows.q(k, 0) + 0.5 - 0.6 * (1.0 - std::cos(w * run.rows.time[k]))));
  }
  EXPECT_LT(worst, 0.05);
  EXPECT_GT(worst, 1e-6);
  // Where both joints stand for an instant in the middle, torques are those of gravity and
  // acceleration: the energy that the motors gave is kinetic, potential and friction. Here: the
  // work of the recorded torques over the closed motion is the heat of friction, which is positive.
  double work = 0.0;
  for (int k = 1; k < run.rows.rows(); ++k)
    work += run.rows.tau.row(k).dot(run.rows.q.row(k) - run.rows.q.row(k - 1));
  double heat = 0.0;
  const double viscous[] = {0.8, 0.4}, dry[] = {1.2, 0.6};
  for (int k = 1; k < run.rows.rows(); ++k) {
    const double dt = run.rows.time[k] - run.rows.time[k - 1];
    for (int j = 0; j < 2; ++j) {
      const double v = (run.rows.q(k, j) - run.rows.q(k - 1, j)) / dt;
      heat += (viscous[j] * v * v + dry[j] * std::abs(v)) * dt;
    }
  }
  EXPECT_NEAR(work, heat, 0.03 * heat);
  EXPECT_FALSE(emulator_.board(0).status().power_requested());
}

TEST_F(ArmRecording, RecordsAtRestWithoutPower) {
  ArmSession arm(link_, planar_config());
  const RunResult run = record_at_rest(arm, link_, 0.5, 1000.0, stop_);
  EXPECT_TRUE(run.complete);
  EXPECT_NEAR(run.rows.rows(), 500, 3);
  EXPECT_LT(run.rows.tau.cwiseAbs().maxCoeff(), 0.01);  // half a bit of current
  EXPECT_EQ(run.rows.dq.cwiseAbs().maxCoeff(), 0.0);
  EXPECT_FALSE(emulator_.board(0).status().power_requested());
}

// No motor is driven, so the recording continues with a remark on its positions.
TEST_F(ArmRecording, EncoderFailuresAreMarkedInTheRecording) {
  for (const char* fault : {"", "overflow", "transition"}) {
    PlanarArm bench;
    EmulatedEncoder& encoder = bench.emulator.board(0).encoder(1);
    ArmSession arm(bench.link, planar_config());
    arm.start();
    const double at = bench.link.now() + 1.0;
    bench.link.each = [&](double now) {
      encoder.overflow_latched = now > at && std::string(fault) == "overflow";
      encoder.broken_lines = now > at && std::string(fault) == "transition";
    };
    const std::string path = testing::TempDir() + "failed-encoders.csv";
    const RunResult run = record_at_rest(arm, bench.link, 1.5, 1000.0, bench.stop, path);
    EXPECT_TRUE(run.complete) << run.why;
    EXPECT_EQ(run.remark.find("the last of board 6, channel 2: positions") != std::string::npos, *fault != 0) << run.remark;
    EXPECT_EQ(first_line(path).rfind("# encoders failed ", 0) == 0, *fault != 0) << first_line(path);
    std::remove(path.c_str());
  }
}

// Boards whose timestamps stand still: the rows have this program's times, and the file has a remark.
TEST_F(ArmRecording, AStalledClockIsMarkedInTheRecording) {
  for (const bool stands : {true, false}) {
    PlanarArm bench;
    bench.emulator.board(0).faults.stops_clock = stands;
    ArmSession arm(bench.link, planar_config());
    RunOptions options;
    options.recording = testing::TempDir() + "stopped-clock.csv";
    const RunResult run = run_motion(arm, bench.link, swinging(1.0, Eigen::Vector2d(0.1, 0.1), 0.05),
                                     sensible_gains(read_model("planar-2r")), options, bench.stop);
    ASSERT_TRUE(run.complete) << run.why;
    const Eigen::Index last = run.rows.rows() - 1;
    EXPECT_NEAR(run.rows.time[last], 1.0, 2e-3);
    const std::string first = first_line(options.recording);
    EXPECT_EQ(first.find("# the clock of board 6 stood still") == 0, stands) << first;
    EXPECT_EQ(run.remark.empty(), !stands);
    std::remove(options.recording.c_str());
  }
}

}  // namespace
}  // namespace veridyn::dvrk
