#include "diagnosis/watch/evidence.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "math/student_t.hpp"
#include "support/random.hpp"

namespace veridyn::watching {
namespace {

constexpr double kStep = 0.1;  // [s]

// Mean 0, standard deviation 1.
double bell(Random& random) {
  return random.vector(12, -0.5, 0.5).sum();
}

const WatchNumbers kNumbers;

WhiteStep white(double time, const VectorXd& e, const MatrixXd& X) {
  WhiteStep s;
  s.time = time;
  s.e = e;
  s.X = X;
  return s;
}

// One joint, one column of ones, and a residual of `size` from `onset` on until `end`.
std::deque<WhiteStep> steps_of(double size, double onset, double end, int count) {
  std::deque<WhiteStep> steps;
  for (int k = 1; k <= count; ++k) {
    const double time = kStep * k;
    const bool on = time > onset && time <= end;
    steps.push_back(white(time, VectorXd::Constant(1, on ? size : 0.0), MatrixXd::Ones(1, 1)));
  }
  return steps;
}

TEST(Evidence, AMemoryDecaysExponentially) {
  Memory m;
  m.forgetting = 0.5;
  m.A = m.b = VectorXd::Zero(1);
  m.add(white(0.1, VectorXd::Constant(1, 3.0), MatrixXd::Constant(1, 1, 2.0)));
  m.add(white(0.2, VectorXd::Constant(1, 1.0), MatrixXd::Constant(1, 1, 1.0)));
  EXPECT_DOUBLE_EQ(m.A[0], 0.5 * 4.0 + 1.0);
  EXPECT_DOUBLE_EQ(m.b[0], 0.5 * 6.0 + 1.0);
  m.clear();
  EXPECT_EQ(m.A[0], 0.0);
}

TEST(Evidence, AnImpossibleSizeCountsAsThePossibleOneNearestToIt) {
  Memory m;
  m.A = Eigen::Vector4d(1.0, 1.0, 1.0, 0.0);
  m.b = Eigen::Vector4d(5.0, -5.0, 0.5, 5.0);
  const VectorXd least = VectorXd::Constant(4, -2.0);
  const VectorXd largest = VectorXd::Constant(4, 1.0);
  const VectorXd s = m.statistics(least, largest);
  EXPECT_DOUBLE_EQ(s[0], 1.0 * (2.0 * 5.0 - 1.0));
  EXPECT_DOUBLE_EQ(s[1], -2.0 * (2.0 * -5.0 + 2.0));
  EXPECT_DOUBLE_EQ(s[2], 0.25);  // possible: b^2 / A
  EXPECT_EQ(s[3], 0.0);          // no information
}

// Two windows of quiet, in which the statistic is too small by a half and will be too large by a half.
TEST(Evidence, ThresholdsAreHigherAfterAShortQuietTime) {
  std::vector<Memory> memories(1);
  memories[0].seconds = 8.0;
  Quantiles quantiles(2, 1, kNumbers);
  EXPECT_TRUE(std::isinf(quantiles.threshold(0)[0]));
  MatrixXd mean(2, 1);
  mean << 4.0, 0.0;
  quantiles.learn(mean, memories, 16.0, 0.5);
  // The prior counts as eight windows of dispersion 3.
  const double quantile = std::pow(student_t_quantile(0.5 * 8.0 / (3600.0 * 2.0), 10.0), 2);
  EXPECT_NEAR(quantiles.threshold(0)[0], (8.0 * 3.0 + 2.0 * 4.0 * 2.25) / 10.0 * quantile, 1e-9);
  EXPECT_NEAR(quantiles.threshold(0)[1], 8.0 * 3.0 / 10.0 * quantile, 1e-9);
  EXPECT_NEAR(quantiles.dispersion(), (4.2 + 2.4) / 2.0, 1e-12);
  EXPECT_NEAR(quantiles.freedom(), 10.0, 1e-12);
}

TEST(Evidence, AMemoryLongerThanTheQuietTimeRaisesNoAlarm) {
  std::vector<Memory> memories(2);
  memories[0].seconds = 0.5;
  memories[1].seconds = 8.0;
  Quantiles quantiles(1, 2, kNumbers);
  quantiles.learn(MatrixXd::Ones(1, 2), memories, 4.0, 0.5);
  EXPECT_TRUE(std::isfinite(quantiles.threshold(0)[0]));
  EXPECT_TRUE(std::isinf(quantiles.threshold(1)[0]));
}

// Fewer alarms an hour need stronger evidence.
TEST(Evidence, ThresholdsFollowTheRateOfFalseAlarms) {
  std::vector<Memory> memories(1);
  memories[0].seconds = 0.5;
  Quantiles rare(1, 1, kNumbers), often(1, 1, kNumbers);
  rare.learn(MatrixXd::Ones(1, 1), memories, 60.0, 0.01);
  often.learn(MatrixXd::Ones(1, 1), memories, 60.0, 1.0);
  EXPECT_GT(rare.threshold(0)[0], 1.2 * often.threshold(0)[0]);
}

TEST(Evidence, TheBestOnsetIsWhereTheResidualBegins) {
  const auto steps = steps_of(3.0, 2.05, 9.0, 40);
  const Score s = best_onset(steps, 0, -10.0, 10.0, 0.0, 4.0);
  EXPECT_NEAR(s.onset, 2.1, 1e-9);
  EXPECT_NEAR(s.size[0], 3.0, 1e-9);
  EXPECT_NEAR(s.gain, 9.0 * 20.0, 1e-9);
  EXPECT_NEAR(s.deviation(), 1.0 / std::sqrt(20.0), 1e-9);
  const Score bounded = best_onset(steps, 0, -10.0, 2.0, 0.0, 4.0);
  EXPECT_NEAR(bounded.size[0], 2.0, 1e-12);
}

TEST(Evidence, AnOnsetLiesBetweenItsBounds) {
  const auto steps = steps_of(3.0, 2.05, 9.0, 40);
  EXPECT_NEAR(best_onset(steps, 0, -10.0, 10.0, 0.0, 1.5).onset, 1.5, 1e-9);
  EXPECT_NEAR(best_onset(steps, 0, -10.0, 10.0, 3.05, 4.0).onset, 3.1, 1e-9);
  EXPECT_EQ(best_onset(steps, 0, -10.0, -1.0, 0.0, 4.0).gain, 0.0);
  EXPECT_TRUE(std::isinf(Score().deviation()));
}

// The step in which a change falls mixes both states; without it the size is the one that holds later.
TEST(Evidence, TheSizeIsReestimatedWithoutItsFirstSteps) {
  auto steps = steps_of(3.0, 2.05, 9.0, 40);
  steps[20].e[0] = 1.0;  // at 2.1 s
  const Score s = best_onset(steps, 0, -10.0, 10.0, 2.05, 2.15);
  EXPECT_LT(s.size[0], 2.95);
  EXPECT_NEAR(reestimated(steps, s, 2.5 * kStep, kNumbers).size[0], 3.0, 1e-9);
  // Nothing is left behind the last step, and a size that doubles is another change.
  EXPECT_EQ(reestimated(steps, s, 5.0, kNumbers).size[0], s.size[0]);
  for (WhiteStep& step : steps)
    if (step.time > 2.35) step.e[0] = 30.0;
  EXPECT_EQ(reestimated(steps, s, 2.5 * kStep, kNumbers).size[0], s.size[0]);
  EXPECT_EQ(reestimated(steps, Score(), 0.1, kNumbers).size.size(), 0);
}

class Companions : public testing::Test {
 protected:
  // A mass whose torque is 1, and a first moment whose torque alternates.
  std::deque<WhiteStep> loaded(double mass, double moment) {
    std::deque<WhiteStep> steps;
    for (int k = 1; k <= 40; ++k) {
      MatrixXd X(1, 2);
      X << 10.0, k % 2 == 0 ? 30.0 : -30.0;
      steps.push_back(white(kStep * k, X * Eigen::Vector2d(mass, moment) +
                                           VectorXd::Constant(1, bell(random_)), X));
    }
    return steps;
  }
  Random random_{5};
};

TEST_F(Companions, AreAddedIfTheyExplainMoreThanTheirPrior) {
  const auto steps = loaded(1.0, 0.1);
  const Score alone = best_onset(steps, 0, 0.0, 5.0, 0.0, kStep);
  const Score both = with_companions(steps, alone, {1}, 10.0, kNumbers);
  ASSERT_EQ(both.columns.size(), 2U);
  EXPECT_NEAR(both.size[1], 0.1, 0.03);
  EXPECT_GT(both.gain, alone.gain + 100.0);
  // The price is higher than what the moment explains.
  EXPECT_EQ(with_companions(steps, alone, {1}, 1e4, kNumbers).columns.size(), 1U);
  EXPECT_EQ(with_companions(steps, alone, {}, 0.0, kNumbers).columns.size(), 1U);
}

// The prior keeps a load's centre within some centimetres of its frame.
TEST_F(Companions, AnImplausibleLeverIsRejected) {
  auto steps = loaded(0.1, 0.0);
  for (WhiteStep& s : steps) s.X.col(1) *= 1e-3;
  for (WhiteStep& s : steps) s.e += 1.0 * s.X.col(1) / 0.03;  // a moment of 33 kg m
  const Score alone = best_onset(steps, 0, 0.0, 5.0, 0.0, kStep);
  const Score both = with_companions(steps, alone, {1}, -1e6, kNumbers);
  EXPECT_LT(std::abs(both.size.tail(both.size.size() - 1).sum()), 0.5);
}

class Pushes : public testing::Test {
 protected:
  // Two joints with an offset each; a torque on the first, or on both, from 2 s to 3 s.
  std::deque<WhiteStep> pushed(double first, double second, double from = 2.05, double to = 3.05) {
    std::deque<WhiteStep> steps;
    for (int k = 1; k <= 50; ++k) {
      const double time = kStep * k;
      Eigen::Vector2d e = Eigen::Vector2d::Zero();
      if (time > from && time < to) e << first, second;
      steps.push_back(white(time, e, MatrixXd::Identity(2, 2)));
    }
    return steps;
  }
  std::vector<int> offsets_ = {0, 1};
};

TEST_F(Pushes, BeginEndAndJointOfAPushAreFound) {
  const Push push = best_push(pushed(6.0, 0.0), offsets_, 1.0, 3.0, 0.8, 4.0, kNumbers);
  EXPECT_NEAR(push.from, 2.1, 1e-9);
  EXPECT_NEAR(push.to, 3.0, 0.2);
  EXPECT_NEAR(push.torque[0], 6.0, 1.2);
  ASSERT_TRUE(push.last_joint.has_value());
  EXPECT_EQ(push.last_joint->value, 0);
  const Push both = best_push(pushed(6.0, 5.0), offsets_, 1.0, 3.0, 0.8, 4.0, kNumbers);
  EXPECT_EQ(both.last_joint->value, 1);
  EXPECT_GT(both.gain, push.gain);
}

// A share below a tenth of the strongest joint's does not move the place of a push outwards.
TEST_F(Pushes, AWeakJointIsNotNamed) {
  const Push push = best_push(pushed(20.0, 3.0), offsets_, 1.0, 3.0, 0.8, 4.0, kNumbers);
  EXPECT_EQ(push.last_joint->value, 0);
}

TEST_F(Pushes, AreNotFoundWithoutAPush) {
  EXPECT_EQ(best_push(pushed(0.0, 0.0), offsets_, 1.0, 3.0, 0.8, 4.0, kNumbers).gain, 0.0);
  EXPECT_EQ(best_push({}, offsets_, 0.0, 1.0, 0.0, 4.0, kNumbers).gain, 0.0);
  // Half a second of 1 explains 5, less than its price.
  EXPECT_EQ(best_push(pushed(1.0, 0.0, 2.05, 2.55), offsets_, 1.0, 3.0, 0.8, 20.0, kNumbers).gain, 0.0);
}

// One that has not ended extends to the last step; one that has ended is at rest for `still`.
TEST_F(Pushes, APushThatLastsExtendsToTheLastStep) {
  const auto steps = pushed(6.0, 0.0, 2.05, 9.0);
  const Push lasting = best_push(steps, offsets_, 1.0, 3.0, 0.0, 4.0, kNumbers);
  EXPECT_NEAR(lasting.to, 5.0, 1e-9);
  const Push ended = best_push(steps, offsets_, 1.0, 3.0, 0.8, 4.0, kNumbers);
  EXPECT_LE(ended.to, 4.2 + 1e-9);
  EXPECT_LT(ended.gain, lasting.gain);
}

}  // namespace
}  // namespace veridyn::watching
