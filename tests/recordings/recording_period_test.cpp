#include "veridyn/recordings/recording_period.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace veridyn {
namespace {

// Three joints with five harmonics each, positions with the noise of an encoder.
Recording fourier_motion(double period, double duration, double rate, double noise) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  MatrixXd amplitude(3, 10);
  for (int k = 0; k < amplitude.size(); ++k) amplitude.data()[k] = normal(random);
  Recording r;
  const int rows = static_cast<int>(duration * rate);
  r.time.resize(rows);
  r.q.resize(rows, 3);
  for (int k = 0; k < rows; ++k) {
    r.time[k] = k / rate;
    for (int j = 0; j < 3; ++j) {
      r.q(k, j) = noise * normal(random);
      for (int h = 1; h <= 5; ++h) {
        const double angle = 2.0 * M_PI * h * r.time[k] / period;
        r.q(k, j) +=
            0.2 / h *
            (amplitude(j, 2 * h - 2) * std::sin(angle) + amplitude(j, 2 * h - 1) * std::cos(angle));
      }
    }
  }
  return r;
}

// The steps of the sampling do not show: the error stays below a twentieth of one.
TEST(APeriod, IsFoundToATwentiethOfASample) {
  for (const double period : {4.7313, 6.4805, 7.0 / 0.9, 11.66666, 20.0}) {
    const MotionPeriod found = detect_period(fourier_motion(period, 30.0, 200.0, 1e-4));
    EXPECT_NEAR(found.seconds, period, 0.05 / 200.0);
    EXPECT_GT(found.confidence, 0.999);
    EXPECT_NEAR(found.repeats, 30.0 / period, 0.02 * 30.0 / period);
  }
}

TEST(APeriod, IsTheShortestAndNotAMultiple) {
  EXPECT_NEAR(detect_period(fourier_motion(2.5, 60.0, 100.0, 1e-4)).seconds, 2.5, 1e-3);
}

TEST(APeriod, IsFoundBetweenRestsAndInIrregularTime) {
  Recording r = fourier_motion(5.0, 30.0, 100.0, 1e-4);
  for (int k = 0; k < 300; ++k) r.q.row(k) = r.q.row(300);
  for (int k = r.rows() - 300; k < r.rows(); ++k) r.q.row(k) = r.q.row(r.rows() - 300);
  EXPECT_NEAR(detect_period(r).seconds, 5.0, 0.01);

  Recording irregular = fourier_motion(5.0, 30.0, 500.0, 1e-5);
  Recording kept;
  std::mt19937 random(3);
  std::vector<int> rows;
  for (int k = 0; k < irregular.rows(); k += 4 + static_cast<int>(random() % 3)) rows.push_back(k);
  kept.time.resize(static_cast<int>(rows.size()));
  kept.q.resize(static_cast<int>(rows.size()), 3);
  for (int k = 0; k < kept.rows(); ++k) {
    kept.time[k] = irregular.time[rows[k]];
    kept.q.row(k) = irregular.q.row(rows[k]);
  }
  EXPECT_NEAR(detect_period(kept).seconds, 5.0, 1e-3);
}

TEST(APeriod, IsNotReportedWithoutARepeatingMotion) {
  EXPECT_FALSE(
      detect_period(fourier_motion(40.0, 30.0, 100.0, 1e-4)).found());  // less than one period
  EXPECT_FALSE(detect_period(Recording()).found());

  Recording resting = fourier_motion(5.0, 30.0, 100.0, 1e-4);
  resting.q *= 1e-3;
  EXPECT_FALSE(detect_period(resting).found());

  Recording walk = fourier_motion(5.0, 30.0, 100.0, 0.0);  // a random walk, low-passed
  std::mt19937 random(9);
  std::normal_distribution<double> normal;
  VectorXd speed = VectorXd::Zero(3);
  for (int k = 1; k < walk.rows(); ++k) {
    for (int j = 0; j < 3; ++j) speed[j] += 0.02 * (normal(random) - speed[j]);
    walk.q.row(k) = walk.q.row(k - 1) + 0.05 * speed.transpose();
  }
  EXPECT_FALSE(detect_period(walk).found());
}

TEST(APeriod, IsFoundInSpiteOfGaps) {
  Recording r = fourier_motion(6.0, 30.0, 100.0, 1e-4);
  for (int k = 100; k < r.rows(); k += 97) r.q(k, k % 3) = NAN;
  EXPECT_NEAR(detect_period(r).seconds, 6.0, 1e-3);
}

}  // namespace
}  // namespace veridyn
