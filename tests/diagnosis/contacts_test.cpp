#include "diagnosis/causes/contacts.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "veridyn/files/model_file.hpp"

// Residuals made by hand: a burst is a contact unless it belongs to the motion.

namespace veridyn {
namespace {

constexpr double kRate = 100.0;
constexpr double kPeriod = 10.0;

class Residuals : public testing::Test {
 protected:
  Residuals() : id_() {
    id_.model = read_model("planar-2r");
    RecordingError r;
    r.source = "push.csv";
    r.period = kPeriod;
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0.0, 0.05);
    PredictionSeries& x = r.series;
    for (auto* table : {&x.q, &x.dq, &x.ddq, &x.measured, &x.modelled}) table->resize(2);
    for (int k = 0; k < 3000; ++k) {
      const double t = k / kRate;
      x.time.push_back(t);
      for (size_t i = 0; i < 2; ++i) {
        const double wave = std::sin(2.0 * M_PI * t / kPeriod + static_cast<double>(i));
        x.q[i].push_back(wave);
        x.dq[i].push_back(2.0 * M_PI / kPeriod * std::cos(2.0 * M_PI * t / kPeriod));
        x.ddq[i].push_back(0.0);
        x.modelled[i].push_back(3.0 * wave);
        x.measured[i].push_back(3.0 * wave + noise(random));
      }
    }
    id_.train.push_back(std::move(r));
  }

  void push(size_t joint, double from, double to, double effort) {
    PredictionSeries& x = id_.train[0].series;
    for (size_t k = 0; k < x.time.size(); ++k) {
      if (x.time[k] >= from && x.time[k] <= to) x.measured[joint][k] += effort;
    }
  }

  Identification id_;
};

TEST_F(Residuals, NoiseIsNoContact) {
  EXPECT_TRUE(find_contacts(id_, {}).empty());
}

TEST_F(Residuals, APushIsFoundWithItsTimeAndItsLastJoint) {
  push(0, 12.0, 13.0, 2.5);
  push(1, 12.0, 13.0, -1.4);
  push(0, 21.0, 21.6, -2.0);
  const std::vector<Contact> found = find_contacts(id_, {});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(found[0].from, 12.0, 0.05);
  EXPECT_NEAR(found[0].to, 13.0, 0.05);
  EXPECT_EQ(found[0].last_joint, 1);
  EXPECT_NEAR(found[0].effort[0], 2.5, 0.1);
  EXPECT_NEAR(found[0].effort[1], -1.4, 0.1);
  EXPECT_EQ(found[1].last_joint, 0);
}

// What a model expects of a joint without torque is no push.
TEST_F(Residuals, AJointWithoutTorqueIsNotPushed) {
  PredictionSeries& x = id_.train[0].series;
  for (size_t k = 0; k < x.time.size(); ++k) {
    x.measured[1][k] = 0.0;
    x.modelled[1][k] = 0.05 * std::sin(40.0 * x.time[k]) + (x.time[k] >= 12.0 && x.time[k] <= 13.0 ? 2.5 : 0.0);
  }
  EXPECT_TRUE(find_contacts(id_, {}).empty());
  push(1, 0.0, 30.0, 1e-3);  // torque it has, and the push is seen
  EXPECT_EQ(find_contacts(id_, {}).size(), 1U);
}

TEST_F(Residuals, WhatReturnsWhereverTheJointPassesThePlaceIsNoContact) {
  id_.train[0].period = 0.0;
  PredictionSeries& x = id_.train[0].series;
  const auto pushed_at_its_end = [&](double until) {
    for (size_t k = 0; k < x.time.size() && x.time[k] < until; ++k) {
      if (x.q[1][k] > 0.95) x.measured[1][k] = x.modelled[1][k] + 2.5;
    }
    return find_contacts(id_, {}).size();
  };
  EXPECT_EQ(pushed_at_its_end(kPeriod), 1U);
  EXPECT_EQ(pushed_at_its_end(3.0 * kPeriod), 0U);
}

// planar-2r has 0.6 N m of friction on joint 2: so much may be wrong at any start.
TEST_F(Residuals, WhatFrictionMayDoIsNoContact) {
  push(1, 12.0, 13.0, 0.5);
  EXPECT_TRUE(find_contacts(id_, {}).empty());
}

// The same bound from friction whose parameter is no "level": 0.6 N m/rad over 1 rad of travel.
TEST_F(Residuals, WhatFrictionOfAnyNameMayDoIsNoContact) {
  ModelDescription other = id_.model->description();
  other.effects.clear();
  id_.model = Model(other);
  push(1, 12.0, 13.0, 0.5);
  EXPECT_EQ(find_contacts(id_, {}).size(), 1U);
  EffectTerm friction;
  friction.effect = "position_dependent_friction";
  friction.axis.coefficients = VectorXd::Unit(2, 1);
  friction.values = {{"slope", 0.6}, {"centre", 0.0}};
  other.effects.push_back(friction);
  id_.model = Model(other);
  EXPECT_TRUE(find_contacts(id_, {}).empty());
}

// As large as a push, but it swings both ways.
TEST_F(Residuals, WhatHasNoDirectionIsNoContact) {
  PredictionSeries& x = id_.train[0].series;
  for (size_t k = 0; k < x.time.size(); ++k) {
    const double t = x.time[k] - 12.0;
    if (t >= 0.0 && t <= 1.0)
      x.measured[1][k] += 1.4 * std::copysign(1.0, std::sin(8.0 * M_PI * t));
  }
  EXPECT_TRUE(find_contacts(id_, {}).empty());
}

TEST_F(Residuals, WhatComesBackEveryPeriodBelongsToTheArm) {
  for (const double turn : {0.0, 1.0, 2.0})
    push(1, 3.0 + turn * kPeriod, 3.8 + turn * kPeriod, 1.0);
  EXPECT_TRUE(find_contacts(id_, {}).empty());
}

TEST_F(Residuals, RowsAroundTheContactAreLeftOut) {
  push(1, 12.0, 13.0, 1.0);
  const std::vector<ExcludedInterval> rows = excluded_intervals(find_contacts(id_, {}));
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].source, "push.csv");
  EXPECT_FALSE(rows[0].joint);
  EXPECT_LT(rows[0].from, 12.0);
  EXPECT_GT(rows[0].to, 13.0);
}

// The low-pass smears anything shorter over a third of a second.
TEST_F(Residuals, WhatIsShorterThanTheFilterIsNoContact) {
  push(0, 12.0, 12.15, 4.0);
  EXPECT_TRUE(find_contacts(id_, {}).empty());
}

// What the model misses slowly is the model's error, however large it becomes.
TEST_F(Residuals, WhatChangesSlowlyIsNoContact) {
  PredictionSeries& x = id_.train[0].series;
  for (size_t k = 0; k < x.time.size(); ++k) x.measured[0][k] += 5.0 * x.time[k] / x.time.back();
  EXPECT_TRUE(find_contacts(id_, {}).empty());
}

// A small part of the torques that a joint has anyway.
TEST_F(Residuals, WhatIsSmallBesideTheTorqueIsNoContact) {
  PredictionSeries& x = id_.train[0].series;
  for (std::vector<double>* torque : {&x.measured[0], &x.modelled[0]}) {
    for (size_t k = 0; k < torque->size(); ++k) (*torque)[k] += 100.0;
  }
  push(0, 12.0, 13.0, 3.0);
  EXPECT_TRUE(find_contacts(id_, {}).empty());
  push(0, 12.0, 13.0, 3.0);
  EXPECT_EQ(find_contacts(id_, {}).size(), 1U);
}

// Two pushes a fifth of a second apart are one that was let go for a moment.
TEST_F(Residuals, PushesThatFollowEachOtherAreOne) {
  push(0, 12.0, 12.5, 2.5);
  push(0, 12.7, 13.2, 2.5);
  const std::vector<Contact> found = find_contacts(id_, {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].from, 12.0, 0.05);
  EXPECT_NEAR(found[0].to, 13.2, 0.05);
}

// Five in half a minute may be pushes; what happens more often belongs to the motion.
TEST_F(Residuals, WhatHappensOftenIsNoContact) {
  id_.train[0].period = 0.0;
  const std::vector<double> times = {1.0, 5.1, 9.4, 13.7, 17.9, 22.4};
  for (size_t k = 0; k < times.size(); ++k) {
    push(0, times[k], times[k] + 0.6, 2.5);
    EXPECT_EQ(find_contacts(id_, {}).size(), k < 5 ? k + 1 : 0) << times[k];
  }
}

// Joints that are pushed one after the other for most of a recording are pushed by nothing that comes and goes.
TEST_F(Residuals, WhatLastsMostOfTheTimeIsNoContact) {
  id_.train[0].period = 0.0;
  const Identification quiet = id_;
  for (const double seconds : {2.0, 3.5}) {
    id_ = quiet;
    for (int k = 0; k < 5; ++k) push(k % 2, 1.0 + 5.9 * k, 1.0 + 5.9 * k + seconds, k < 2 ? 2.5 : -2.5);
    EXPECT_EQ(find_contacts(id_, {}).size(), seconds < 3.0 ? 5U : 0U) << seconds;
  }
}

// A joint that trembles about its pose has no reversals at which friction may do what a push does.
TEST_F(Residuals, OfAJointAtRestFrictionIsNoReason) {
  PredictionSeries& x = id_.train[0].series;
  for (size_t k = 0; k < x.time.size(); ++k) {
    x.q[1][k] = 0.3 + 2e-3 * std::sin(20.0 * x.time[k]);
    x.dq[1][k] = 0.04 * std::cos(20.0 * x.time[k]);
  }
  push(1, 12.0, 13.0, 0.5);
  EXPECT_EQ(find_contacts(id_, {}).size(), 1U);
  Thresholds any_motion;
  any_motion.still_revolute = 1e-3;
  EXPECT_TRUE(find_contacts(id_, any_motion).empty());
}

// Ten samples a second.
TEST_F(Residuals, AFewSamplesTellNothing) {
  PredictionSeries& x = id_.train[0].series;
  for (double& time : x.time) time *= 10.0;
  push(0, 2.0, 2.6, 5.0);
  for (const size_t samples : {60, 49}) {
    for (auto* table : {&x.q, &x.dq, &x.ddq, &x.measured, &x.modelled}) {
      for (std::vector<double>& joint : *table) joint.resize(samples);
    }
    x.time.resize(samples);
    EXPECT_EQ(find_contacts(id_, {}).size(), samples > 50 ? 1U : 0U) << samples;
  }
}

TEST_F(Residuals, FindingsSayWhenWhereAndHowHard) {
  push(1, 12.0, 13.0, -1.4);
  push(0, 21.0, 21.6, -2.0);
  id_.test_error.relative = Eigen::Vector2d(0.3, 0.2);
  id_.test_without_excluded.relative = Eigen::Vector2d(0.1, 0.1);
  Diagnosis d;
  add_contacts(find_contacts(id_, {}), id_, d);
  ASSERT_EQ(d.findings.size(), 2U);
  EXPECT_EQ(d.findings[0].rank, 1);
  EXPECT_EQ(d.findings[1].rank, 2);
  const Finding& f = d.findings[0];
  EXPECT_EQ(f.joint, JointIndex{1});
  EXPECT_EQ(f.source, "push.csv");
  ASSERT_EQ(f.parameters.size(), 3U);
  EXPECT_LT(f.parameters[0].low, -1.4);
  EXPECT_GT(f.parameters[0].high, -1.4);
  EXPECT_GT(f.parameters[0].low, -2.0);
  EXPECT_NEAR(f.parameters[1].value, 12.0, 0.05);
  EXPECT_NEAR(f.parameters[2].value, 13.0, 0.05);
  EXPECT_LT(f.p_value, 1e-3);
  EXPECT_EQ(f.test_before, id_.test_error.relative);
  EXPECT_EQ(f.test_outside, id_.test_without_excluded.relative);
  EXPECT_NE(f.phrase.find("pushes the arm on link fore or beyond it"), std::string::npos) << f.phrase;
}

}  // namespace
}  // namespace veridyn
