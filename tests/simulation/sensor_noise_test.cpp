#include "veridyn/simulation/sensor_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "simulation_support.hpp"
#include "support/near.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

double rms(const VectorXd& x) {
  return std::sqrt(x.squaredNorm() / static_cast<double>(x.size()));
}

// Correlation of neighbours.
double correlation(const VectorXd& x, Eigen::Index lag) {
  const Eigen::Index n = x.size() - lag;
  return x.head(n).dot(x.tail(n)) / x.head(n).squaredNorm();
}

SimulatedRecording with(const SensorNoise& noise) {
  return simulated(read_model("scara"), {}, noise);
}

// 2001 samples: a standard deviation is known to 1 / sqrt(2 * 2001) = 1.6 %; four of these are
// allowed.
constexpr double kSpread = 0.065;

TEST(SensorNoise, VelocityNoiseIsWhiteAndOfItsSize) {
  SensorNoise noise;
  noise.velocity = {0.02, 0.003};
  const SimulatedRecording s = with(noise);
  const MatrixXd e = s.measured.dq - s.actual.dq;
  EXPECT_NEAR(rms(e.col(0)) / 0.02, 1.0, kSpread);
  EXPECT_NEAR(rms(e.col(2)) / 0.003, 1.0, kSpread);  // the quill slides
  EXPECT_NEAR(correlation(e.col(0), 1), 0.0, 4.0 / std::sqrt(2000.0));
  EXPECT_TRUE(near(s.measured.q, s.actual.q, 0.0));
  EXPECT_TRUE(near(s.tau, s.actual_tau, 0.0));
}

TEST(SensorNoise, WhiteTorqueNoiseIsAShareOfTheRmsTorque) {
  SensorNoise noise;
  noise.torque_white = 0.05;
  const SimulatedRecording s = with(noise);
  for (int i = 0; i < 4; ++i) {
    const VectorXd e = s.tau.col(i) - s.actual_tau.col(i);
    EXPECT_NEAR(rms(e) / (0.05 * rms(s.actual_tau.col(i))), 1.0, kSpread);
    EXPECT_NEAR(correlation(e, 1), 0.0, 4.0 / std::sqrt(2000.0));
  }
}

// Correlation exp(-dt / T). 10 s hold about 10 / (2 * 0.02) independent samples.
TEST(SensorNoise, ColouredTorqueNoiseHasItsCorrelationTime) {
  SensorNoise noise;
  noise.torque_coloured = 0.05;
  noise.colour_seconds = 0.02;
  const SimulatedRecording s = with(noise);
  const VectorXd e = s.tau.col(0) - s.actual_tau.col(0);
  EXPECT_NEAR(rms(e) / (0.05 * rms(s.actual_tau.col(0))), 1.0, 4.0 / std::sqrt(2.0 * 250.0));
  EXPECT_NEAR(correlation(e, 1), std::exp(-0.005 / 0.02), 0.06);
}

TEST(SensorNoise, PositionsAreMultiplesOfTheEncoderStep) {
  SensorNoise noise;
  noise.encoder_step = {1e-3, 1e-4};
  const SimulatedRecording s = with(noise);
  const Eigen::ArrayXd steps = s.measured.q.col(0).array() / 1e-3;
  EXPECT_LT((steps - steps.round()).abs().maxCoeff(), 1e-9);
  EXPECT_LE((s.measured.q - s.actual.q).col(0).cwiseAbs().maxCoeff(), 0.5e-3 + 1e-12);
  EXPECT_LE((s.measured.q - s.actual.q).col(2).cwiseAbs().maxCoeff(), 0.5e-4 + 1e-12);
}

TEST(SensorNoise, StaleRowsRepeatEverythingButTime) {
  SensorNoise noise;
  noise.stale_rows = 0.1;
  const SimulatedRecording s = with(noise);
  int stale = 0;
  for (Eigen::Index k = 1; k < s.tau.rows(); ++k) {
    if (s.measured.q.row(k) != s.measured.q.row(k - 1)) continue;
    ++stale;
    EXPECT_EQ(s.tau.row(k), s.tau.row(k - 1));
    EXPECT_EQ(s.measured.dq.row(k), s.measured.dq.row(k - 1));
    EXPECT_GT(s.measured.time[k], s.measured.time[k - 1]);
  }
  EXPECT_NEAR(stale / 2000.0, 0.1, 4.0 * std::sqrt(0.1 * 0.9 / 2000.0));
}

// How many of the rows after the first are `bad`, and in how many runs.
template <typename Bad>
std::pair<int, int> rows_and_runs(Eigen::Index rows, const Bad& bad) {
  std::pair<int, int> out{0, 0};
  for (Eigen::Index k = 1; k < rows; ++k) {
    if (!bad(k)) continue;
    ++out.first;
    if (k == 1 || !bad(k - 1)) ++out.second;
  }
  return out;
}

TEST(SensorNoise, StaleRowsAndDropoutsHaveTheirMeanRunLength) {
  SensorNoise noise;
  noise.stale_rows = 0.2;
  noise.stale_run = 4.0;
  noise.dropouts = 0.1;
  noise.dropout_run = 10.0;
  std::pair<int, int> stale{0, 0};
  std::pair<int, int> missing{0, 0};
  for (unsigned seed = 1; seed <= 20; ++seed) {  // 40000 rows
    const Model arm = read_model("scara");
    MotionSamples m = waves(4);
    MatrixXd tau = m.dq;
    measure(arm, noise, seed, m, tau);
    const auto gap = [&](Eigen::Index k) { return std::isnan(m.q(k, 0)); };
    const auto repeats = [&](Eigen::Index k) { return k > 0 && m.q.row(k) == m.q.row(k - 1); };
    const auto of_stale = rows_and_runs(m.rows(), repeats);
    const auto of_missing = rows_and_runs(m.rows(), gap);
    stale = {stale.first + of_stale.first, stale.second + of_stale.second};
    missing = {missing.first + of_missing.first, missing.second + of_missing.second};
    for (Eigen::Index k = 1; k < m.rows(); ++k) {
      EXPECT_TRUE(!gap(k) || (std::isnan(m.dq(k, 1)) && std::isnan(tau(k, 2))));
    }
  }
  // 400 runs of gaps: their number is known to about 5 %, and so is their length.
  EXPECT_NEAR(missing.first / 40000.0, 0.1, 0.02);
  EXPECT_NEAR(static_cast<double>(missing.first) / missing.second, 10.0, 1.5);
  // Gaps hide a tenth of the repeats and cut some of their runs.
  EXPECT_NEAR(stale.first / 36000.0, 0.2, 0.02);
  EXPECT_NEAR(static_cast<double>(stale.first) / stale.second, 4.0, 0.5);
}

TEST(SensorNoise, ADelayShiftsEverySignal) {
  SensorNoise noise;
  noise.delay = 0.0123;
  const SimulatedRecording s = with(noise);
  for (const Eigen::Index k : {500, 1234, 1999}) {
    const double shift = -noise.delay;
    for (Eigen::Index i = 0; i < s.tau.cols(); ++i) {
      const double q =
          s.actual.q(k, i) + shift * s.actual.dq(k, i) + 0.5 * shift * shift * s.actual.ddq(k, i);
      EXPECT_NEAR(s.measured.q(k, i), q, 1e-5);
      EXPECT_NEAR(s.measured.dq(k, i), s.actual.dq(k, i) + shift * s.actual.ddq(k, i), 2e-3);
    }
  }
}

// A row that is late by d shows a position that is off by d times the velocity.
TEST(SensorNoise, LateRowsDeviateByDelayTimesVelocity) {
  SensorNoise noise;
  noise.late = 1e-3;
  const SimulatedRecording s = with(noise);
  const double fast = 0.5 * s.actual.dq.col(0).cwiseAbs().maxCoeff();
  std::vector<double> late;
  for (Eigen::Index k = 100; k < s.tau.rows(); ++k) {
    const double v = s.actual.dq(k, 0);
    if (std::abs(v) > fast) late.push_back((s.actual.q(k, 0) - s.measured.q(k, 0)) / v);
  }
  ASSERT_GT(late.size(), 500u);
  double sum = 0.0;
  for (const double d : late) {
    EXPECT_GT(d, -1e-5);
    sum += d;
  }
  // The mean size of a normal number is sqrt(2 / pi) = 0.80 of its deviation; rows in order are a
  // little later still.
  EXPECT_NEAR(sum / static_cast<double>(late.size()), 0.8e-3, 0.1e-3);
}

// Velocity and acceleration are derivatives, by central differences. At most 5 mrad of waves with
// omega below 3.2 and a fade with derivatives below 6, 60 and 360 have third derivatives below 1
// and fourth ones below 10. The fade's third derivative jumps where it begins and ends.
TEST(SensorNoise, DerivativesOfTheTrackingDeviationAreConsistent) {
  SensorNoise noise;
  noise.tracking = {1e-3, 1e-4};
  const SimulatedRecording s = with(noise);
  const MotionSamples wanted = waves(4);
  const MatrixXd q = s.actual.q - wanted.q;
  const MatrixXd dq = s.actual.dq - wanted.dq;
  const MatrixXd ddq = s.actual.ddq - wanted.ddq;
  const double h = 0.005;
  const auto slope = [h](const MatrixXd& x, Eigen::Index first, Eigen::Index rows) -> MatrixXd {
    return (x.middleRows(first + 1, rows) - x.middleRows(first - 1, rows)) / (2.0 * h);
  };
  for (const auto& [first, rows] :
       {std::pair(2, 196), std::pair(202, 1596), std::pair(1803, 195)}) {
    EXPECT_TRUE(near(slope(q, first, rows), dq.middleRows(first, rows), h * h / 6));
    EXPECT_TRUE(near(slope(dq, first, rows), ddq.middleRows(first, rows), 10 * h * h / 6));
  }
  EXPECT_NEAR(rms(q.col(0)), 1e-3, 0.6e-3);
  EXPECT_NEAR(rms(q.col(2)), 1e-4, 0.6e-4);
}

TEST(SensorNoise, TheTrackingDeviationBeginsAndEndsAtRest) {
  SensorNoise noise;
  noise.tracking = {1e-3, 1e-4};
  const SimulatedRecording s = with(noise);
  const MotionSamples wanted = waves(4);
  for (const Eigen::Index row : {0, 2000}) {
    EXPECT_TRUE(near(s.actual.q.row(row), wanted.q.row(row), 1e-15));
    EXPECT_TRUE(near(s.actual.dq.row(row), wanted.dq.row(row), 1e-15));
    EXPECT_TRUE(near(s.actual.ddq.row(row), wanted.ddq.row(row), 1e-15));
  }
}

TEST(SensorNoise, JointsAtRestStayAtRest) {
  const Model arm = read_model("scara");
  MotionSamples wanted = waves(4);
  wanted.q.col(1).setConstant(0.2);
  wanted.dq.col(1).setZero();
  wanted.ddq.col(1).setZero();
  const MotionSamples actual = with_tracking_deviation(arm, wanted, sensor_noise("dvrk"), 1);
  EXPECT_TRUE(near(actual.q.col(1), wanted.q.col(1), 0.0));
  EXPECT_GT((actual.q.col(0) - wanted.q.col(0)).norm(), 0.0);
}

TEST(SensorNoise, EveryPresetIsDescribed) {
  for (const std::string& name : sensor_noise_names())
    EXPECT_FALSE(describe(sensor_noise(name)).empty());
  EXPECT_THROW(sensor_noise("lo"), InvalidInput);
}

TEST(SensorNoise, GivenAmountsOverrideThePreset) {
  const SensorNoise noise = sensor_noise("dvrk:stale_rows=0.3,delay=5e-3,dropouts=1/100");
  EXPECT_EQ(noise.stale_rows, 0.3);
  EXPECT_EQ(noise.delay, 5e-3);
  EXPECT_EQ(noise.dropouts, 0.01);
  EXPECT_EQ(noise.torque_white, sensor_noise("dvrk").torque_white);
  for (const char* wrong : {"dvrk:", "dvrk:stale=0.1", "dvrk:late", "dvrk:late=-1", "dvrk:late=x",
                            "dvrk:stale_rows=1.5", "dvrk:stale_run=0", "dvrk:late=1,"})
    EXPECT_THROW(sensor_noise(wrong), InvalidInput) << wrong;
}

}  // namespace
}  // namespace veridyn
