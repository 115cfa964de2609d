#include "excitation/slow_passes.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/near.hpp"
#include "veridyn/excitation/excitation.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

constexpr double kRate = 200.0;

MotionLimits limits() {
  return {Eigen::Vector2d(-1.0, 0.0), Eigen::Vector2d(1.0, 0.2), Eigen::Vector2d(2.0, 0.4),
          Eigen::Vector2d(10.0, 2.0)};
}

bool always(const MotionSamples&) {
  return true;
}

MotionSamples passes(const VectorXd& rest, int count) {
  return slow_passes(limits(), rest, {0, 1}, count, kRate, always);
}

TEST(SlowPasses, BeginAndEndAtRestAtTheGivenPosition) {
  const Eigen::Vector2d rest(0.3, 0.15);
  const MotionSamples m = passes(rest, 2);
  for (const Eigen::Index row : {Eigen::Index{0}, m.rows() - 1}) {
    EXPECT_TRUE(near(m.q.row(row), rest.transpose(), 1e-12));
    EXPECT_TRUE(near(m.dq.row(row), MatrixXd::Zero(1, 2), 1e-12));
    EXPECT_TRUE(near(m.ddq.row(row), MatrixXd::Zero(1, 2), 1e-12));
  }
}

// Central differences of q are dq, and those of dq are ddq.
TEST(SlowPasses, VelocitiesAndAccelerationsAreDerivatives) {
  const MotionSamples m = passes(Eigen::Vector2d(0.3, 0.15), 3);
  const double h = 1.0 / kRate;
  for (Eigen::Index k = 1; k + 1 < m.rows(); ++k) {
    ASSERT_NEAR(m.time[k + 1] - m.time[k], h, 1e-9) << k;
    for (Eigen::Index i = 0; i < 2; ++i) {
      ASSERT_NEAR((m.q(k + 1, i) - m.q(k - 1, i)) / (2 * h), m.dq(k, i), 5e-4) << k;
      ASSERT_NEAR((m.dq(k + 1, i) - m.dq(k - 1, i)) / (2 * h), m.ddq(k, i), 5e-2) << k;
    }
  }
}

TEST(SlowPasses, KeepTheLimitsAndMoveOneJointAtATime) {
  for (const double where : {-0.999, -0.5, 0.0, 0.97}) {
    const MotionSamples m = passes(Eigen::Vector2d(where, 0.199), 3);
    const MotionLimits l = limits();
    for (int i = 0; i < 2; ++i) {
      EXPECT_GE(m.q.col(i).minCoeff(), l.lower[i]) << where;
      EXPECT_LE(m.q.col(i).maxCoeff(), l.upper[i]) << where;
      EXPECT_LE(m.ddq.col(i).cwiseAbs().maxCoeff(), l.acceleration[i]) << where;
    }
    EXPECT_EQ((m.dq.col(0).array() != 0.0 && m.dq.col(1).array() != 0.0).count(), 0);
  }
}

// Long segments at 1, sqrt(10) and 10 % of the largest speed in both directions, three reversals
// in each pass.
TEST(SlowPasses, HoldThreeSpeedsInBothDirections) {
  const MotionSamples m = passes(Eigen::Vector2d(0.0, 0.1), 3);
  for (int i = 0; i < 2; ++i) {
    for (const double share : {0.01, std::sqrt(1e-3), 0.1}) {
      for (const double sign : {-1.0, 1.0}) {
        const double wanted = sign * share * limits().velocity[i];
        const auto there = (m.dq.col(i).array() - wanted).abs() < 1e-9;
        EXPECT_GT(static_cast<double>(there.count()) / kRate, 2.0) << share;
      }
    }
    int reversals = 0;
    double direction = 0.0;
    for (Eigen::Index k = 0; k < m.rows(); ++k) {
      const double v = m.dq(k, i);
      if (std::abs(v) < 1e-12 && std::abs(m.ddq(k, i)) < 1e-12) direction = 0.0;  // between passes
      if (std::abs(v) < 1e-12) continue;
      if (v * direction < 0.0) ++reversals;
      direction = v;
    }
    EXPECT_EQ(reversals, 9);
  }
}

TEST(SlowPasses, AreShortenedUntilOtherLimitsHold) {
  const auto near_home = [](const MotionSamples& m) {
    return (m.q.col(0).array() - 0.3).abs().maxCoeff() < 0.05;
  };
  const MotionSamples m =
      slow_passes(limits(), Eigen::Vector2d(0.3, 0.1), {0, 1}, 2, kRate, near_home);
  EXPECT_TRUE(near_home(m));
  EXPECT_GT((m.q.col(0).array() - 0.3).abs().maxCoeff(), 0.01);
  const auto never = [](const MotionSamples&) { return false; };
  EXPECT_EQ(slow_passes(limits(), Eigen::Vector2d(0.3, 0.1), {0, 1}, 2, kRate, never).rows(), 0);
}

TEST(SlowPasses, AreAppendedAfterTheLastPeriodWithinLimits) {
  ExcitationOptions options;
  options.starts = 1;
  options.iterations = 10;
  options.slow_passes = 1;
  options.workspace.boxes = {{"tool", {-0.5, -0.5, -0.5}, {0.6, 0.5, 0.5}}};
  const Excitation e = optimise_excitation(read_model("psm-3dof"), options);
  ASSERT_EQ(e.status, ExcitationStatus::kDone);
  EXPECT_GT(e.slow_seconds, 20.0);
  const double end = e.periods * e.trajectory.period();
  EXPECT_NEAR(e.motion.time[e.motion.rows() - 1], end + e.slow_seconds, 2.0 / options.rate);
  for (const LimitMargin& m : e.margins) EXPECT_GE(m.margin, 0.0) << m.name;
  for (Eigen::Index k = 1; k < e.motion.rows(); ++k) {
    ASSERT_LT((e.motion.q.row(k) - e.motion.q.row(k - 1)).cwiseAbs().maxCoeff(), 0.02) << k;
  }
}

}  // namespace
}  // namespace veridyn
