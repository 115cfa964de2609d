#include "diagnosis/watch/noise.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/random.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn::watching {
namespace {

constexpr double kStep = 0.1;  // [s]

// Mean 0, standard deviation 1.
double bell(Random& random) {
  return random.vector(12, -0.5, 0.5).sum();
}

// Steps of planar-2r whose offsets are the hypotheses; the joints' residuals are made by a test.
class Noise : public testing::Test {
 protected:
  Step step(double residual0, double residual1 = 0.0) {
    Step s;
    s.time = time_ += kStep;
    s.residual = Eigen::Vector2d(residual0, residual1);
    s.torque = Eigen::Vector2d(2.0, -2.0);
    s.position = VectorXd::Zero(2);
    s.columns = MatrixXd::Identity(2, 2);
    s.rest_friction2 = VectorXd::Zero(2);
    s.parts = MatrixXd::Ones(2, 3);
    return s;
  }

  // Coefficients of the first joint's autoregression, from its answer to a single residual.
  Eigen::Vector2d coefficients() {
    const VectorXd none = VectorXd::Zero(2);
    Step impulse = step(noise_.daily_offsets()[0] + 1.0);
    impulse.follows = false;
    noise_.whiten(impulse, none);
    Eigen::Vector2d a;
    for (double& one : a) {
      Step quiet = step(noise_.daily_offsets()[0]);
      one = -noise_.whiten(quiet, none).e[0] * noise_.deviation()[0];
    }
    return a;
  }

  std::vector<Step> autoregressive(double pole, double innovation, int count) {
    std::vector<Step> steps;
    double x = 0.0;
    for (int k = 0; k < count; ++k) steps.push_back(step(x = pole * x + innovation * bell(random_)));
    return steps;
  }

  double time_ = 0.0;
  Random random_{3};
  Model arm_ = plausible_model(read_model("planar-2r"), 1).arm;
  std::vector<Hypothesis> offsets_ = {
      {Candidate{NewEffect{"torque_offset", JointIndex{0}}, JointIndex{0}, {}, {}}},
      {Candidate{NewEffect{"torque_offset", JointIndex{1}}, JointIndex{1}, {}, {}}}};
  WatchNumbers numbers_;
  NoiseModel noise_{arm_, offsets_, numbers_};
};

TEST_F(Noise, EstimatesThePoleAndTheInnovationVariance) {
  noise_.fit(autoregressive(0.9, 0.5, 4000), {});
  const Eigen::Vector2d a = coefficients();
  EXPECT_NEAR(a[0], 0.9, 0.05);
  EXPECT_NEAR(a[1], 0.0, 0.05);
  EXPECT_NEAR(noise_.deviation()[0], 0.5, 0.02);
  EXPECT_NEAR(noise_.scale()[0], 2.0, 1e-9);
}

// Least squares of a growing residual has poles outside the unit circle, and a filter with the
// inverse of those would make every later residual small.
TEST_F(Noise, PolesStayInsideTheUnitCircle) {
  for (const double growth : {1.05, -1.05}) {
    std::vector<Step> growing;
    double x = 0.1;
    for (int k = 0; k < 60; ++k) growing.push_back(step(x *= growth));
    noise_.fit(growing, {});
    const Eigen::Vector2d a = coefficients();
    EXPECT_LT(std::abs(a[1]), 0.981) << growth;
    EXPECT_LT(std::abs(a[0]), 1.0 - a[1]) << growth;
  }
  std::vector<Step> oscillating;  // a[1] alone is beyond its bound
  double size = 0.1;
  for (int k = 0; k < 60; ++k) oscillating.push_back(step((size *= 1.05) * std::cos(M_PI_2 * k)));
  noise_.fit(oscillating, {});
  EXPECT_NEAR(coefficients()[1], -0.98, 1e-9);
}

TEST_F(Noise, DailyOffsetsAreEstimatedUnderAutoregressiveNoise) {
  std::vector<Step> today = autoregressive(0.8, 0.1, 600);
  for (Step& s : today) {
    s.residual[0] += 2.0;
    s.torque[0] = 10.0;  // five times the offset
  }
  noise_.fit({}, today);
  EXPECT_NEAR(noise_.daily_offsets()[0], 2.0, 0.15);
  EXPECT_NEAR(noise_.daily_offsets()[1], 0.0, 1e-6);
  EXPECT_NEAR(noise_.rest(today[7], VectorXd::Unit(2, 0))[0],
              today[7].residual[0] - noise_.daily_offsets()[0] - 1.0, 1e-12);
}

// A few steps do not outweigh the prior: the day's difference is the ridge estimate whose prior deviation gives,
// at the speed `slow`, the torque that the joint had; an offset has no speed. Joints at rest have no autoregression.
TEST_F(Noise, DifferencesOfADayAreTheRidgeEstimateOfTheirPrior) {
  std::vector<Hypothesis> damping;
  for (const int j : {0, 1})
    damping.push_back({Candidate{NewEffect{"viscous_friction", JointIndex{j}}, JointIndex{j}, {}, {}}});
  for (const auto* asked : {&offsets_, &damping}) {
    const double speed = asked == &damping ? numbers_.slow : 1.0;
    NoiseModel model(arm_, *asked, numbers_);
    std::vector<Step> today;
    double power = 0.0, xx = 0.0, xe = 0.0;
    constexpr double kRest = 1.0;
    for (int k = 0; k < 12; ++k) {
      const double x = speed * (1.0 + 0.1 * k), e = 30.0 + 20.0 * bell(random_);
      today.push_back(step(e));
      today.back().columns *= x;
      today.back().rest_friction2[0] = kRest;
      power += e * e / 12.0;
      xx += x * x;
      xe += x * e;
    }
    model.fit({}, today);
    const double variance = power + kRest, prior = today[0].torque[0] / speed;
    EXPECT_NEAR(model.daily_offsets()[0], xe / (xx + variance / (prior * prior)), 1e-9 * xe / xx);
  }
}

TEST_F(Noise, StepsAtRestDoNotChangeTheEstimate) {
  std::vector<Step> steps = autoregressive(0.0, 0.2, 900);
  for (size_t k = 0; k < steps.size(); ++k) {
    if (k % 30 > 9) continue;
    steps[k].residual[0] = k % 2 == 0 ? 8.0 : -8.0;
    steps[k].rest_friction2[0] = 64.0;
  }
  noise_.fit(steps, {});
  EXPECT_NEAR(noise_.deviation()[0], 0.2, 0.03);
  EXPECT_NEAR(coefficients()[0], 0.0, 0.1);
}

// A joint that always rests has no autoregression; its residual as a whole is its noise.
TEST_F(Noise, AJointThatAlwaysRestsHasTheSpreadOfItsResidual) {
  std::vector<Step> steps = autoregressive(0.9, 0.5, 300);
  double power = 0.0;
  for (Step& s : steps) {
    s.rest_friction2[0] = 1.0;
    power += s.residual[0] * s.residual[0] / 300.0;
  }
  noise_.fit(steps, {});
  EXPECT_NEAR(noise_.deviation()[0], std::sqrt(power), 1e-9);
  EXPECT_NEAR(coefficients()[0], 0.0, 1e-12);
}

// Pieces of five steps, each at a level of its own: what happens between pieces is no innovation.
TEST_F(Noise, SeparateRecordingsAreNotJoined) {
  std::vector<Step> steps;
  for (int k = 0; k < 500; ++k) {
    const int piece = k / 5;
    steps.push_back(step((piece % 2 == 0 ? 5.0 : -5.0) + 0.01 * bell(random_)));
    steps.back().follows = k % 5 != 0;
  }
  noise_.fit(steps, {});
  EXPECT_LT(noise_.deviation()[0], 0.2);  // 0.1 from the poles' bound, 5 if pieces were joined
  // Nor does whitening predict the first step of a piece from the last step of the piece before.
  const VectorXd none = VectorXd::Zero(2);
  noise_.whiten(steps[4], none);
  EXPECT_NEAR(noise_.whiten(steps[5], none).e[0] * noise_.deviation()[0], steps[5].residual[0], 1e-9);
}

TEST_F(Noise, ATorqueBeyondItsRangeIsUnseenMotion) {
  noise_.fit(autoregressive(0.0, 0.2, 400), {});
  Step s = step(0.0);
  EXPECT_FALSE(noise_.novel(s));
  s.parts(0, 1) = 1.05;  // within a tenth of what was seen
  EXPECT_FALSE(noise_.novel(s));
  s.parts(0, 1) = 1.3;  // half of the 0.2 beyond that is less than the noise
  EXPECT_FALSE(noise_.novel(s));
  s.parts(0, 1) = 2.1;
  EXPECT_TRUE(noise_.novel(s));
}

// The model is not trusted beyond the learned range: half of what is beyond adds to the noise.
TEST_F(Noise, RestAndUnseenMotionWeighLess) {
  noise_.fit(autoregressive(0.0, 0.2, 4000), {});
  const double deviation = noise_.deviation()[0];
  const VectorXd none = VectorXd::Zero(2);
  const auto weight = [&](Step s) {
    s.follows = false;
    return noise_.whiten(s, none).X(0, 0);
  };
  EXPECT_NEAR(weight(step(0.0)), 1.0 / deviation, 1e-9);
  Step unseen = step(0.0);
  unseen.parts(0, 2) = 3.1;
  EXPECT_NEAR(weight(unseen), 1.0 / std::hypot(deviation, 1.0), 1e-9);
  Step rests = step(0.0);
  rests.rest_friction2[0] = 4.0;
  EXPECT_NEAR(weight(rests), 1.0 / std::hypot(deviation, 2.0), 1e-9);
}

TEST_F(Noise, TooFewStepsChangeNothing) {
  noise_.fit(autoregressive(0.0, 0.2, 7), {});
  EXPECT_EQ(noise_.deviation()[0], 1.0);
}

}  // namespace
}  // namespace veridyn::watching
