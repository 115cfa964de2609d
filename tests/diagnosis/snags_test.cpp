#include "diagnosis/causes/snags.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "veridyn/files/model_file.hpp"

// Friction by place in four recordings, made by hand.

namespace veridyn {
namespace {

RecordingError to_and_fro(const std::string& source, unsigned seed) {
  RecordingError r;
  r.source = source;
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, 0.02);
  PredictionSeries& x = r.series;
  for (auto* table : {&x.q, &x.dq, &x.ddq, &x.measured, &x.modelled}) table->resize(2);
  for (int k = 0; k < 4000; ++k) {
    const double t = 0.01 * k;
    x.time.push_back(t);
    for (size_t i = 0; i < 2; ++i) {
      x.q[i].push_back(std::sin(t));
      x.dq[i].push_back(std::cos(t));
      x.ddq[i].push_back(-std::sin(t));
      x.modelled[i].push_back(std::sin(2.0 * t));
      x.measured[i].push_back(std::sin(2.0 * t) + noise(random));
    }
  }
  return r;
}

Identification four_recordings() {
  Identification id;
  id.model = read_model("planar-2r");
  for (unsigned k = 0; k < 4; ++k)
    id.train.push_back(to_and_fro("recording" + std::to_string(k), k + 1));
  return id;
}

void add_friction(RecordingError& r, size_t joint, double from, double to, double level) {
  PredictionSeries& x = r.series;
  for (size_t k = 0; k < x.time.size(); ++k) {
    if (x.q[joint][k] > from && x.q[joint][k] < to)
      x.measured[joint][k] += x.dq[joint][k] > 0.0 ? level : -level;
  }
}

TEST(Snags, FrictionAtOnePlaceOfOneRecordingIsFoundAndLeftOut) {
  Identification id = four_recordings();
  add_friction(id.train[2], 1, 0.2, 0.5, 0.4);
  const std::vector<Snag> found = find_snags(id, {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].source, "recording2");
  EXPECT_EQ(found[0].joint, 1);
  EXPECT_NEAR(found[0].from, 0.2, 0.1);
  EXPECT_NEAR(found[0].to, 0.5, 0.1);
  EXPECT_NEAR(found[0].friction, 0.4, 0.1);
  for (const ExcludedInterval& part : excluded_intervals(found, id)) {
    EXPECT_EQ(part.source, "recording2");
    EXPECT_EQ(part.joint, 1);
    EXPECT_LT(part.from, part.to);
  }
}

// What a model expects of a joint without torque sticks nowhere.
TEST(Snags, AJointWithoutTorqueDoesNotStick) {
  Identification id = four_recordings();
  for (RecordingError& r : id.train) {
    r.series.measured[1].assign(r.series.time.size(), 0.0);
    r.series.modelled[1] = r.series.measured[1];
  }
  PredictionSeries& x = id.train[2].series;
  for (size_t k = 0; k < x.time.size(); ++k) {
    if (x.q[1][k] > 0.2 && x.q[1][k] < 0.5) x.modelled[1][k] = x.dq[1][k] > 0.0 ? -0.4 : 0.4;
  }
  EXPECT_TRUE(find_snags(id, {}).empty());
  id.train[0].series.measured[1][0] = 1e-3;  // torque it has, and sticks
  EXPECT_FALSE(find_snags(id, {}).empty());
}

TEST(Snags, FrictionThatAllRecordingsHaveIsOfTheArm) {
  Identification id = four_recordings();
  for (RecordingError& r : id.train) add_friction(r, 1, 0.2, 0.5, 0.4);
  EXPECT_TRUE(find_snags(id, {}).empty());
}

TEST(Snags, TwoRecordingsCannotTellWhoseFrictionItIs) {
  Identification id = four_recordings();
  id.train.resize(2);
  add_friction(id.train[1], 1, 0.2, 0.5, 0.4);
  EXPECT_TRUE(find_snags(id, {}).empty());
}

// The same friction beside large torques may be anything.
TEST(Snags, SmallFrictionBesideLargeTorquesIsNone) {
  Identification id = four_recordings();
  for (RecordingError& r : id.train) {
    for (std::vector<double>* torque : {&r.series.measured[1], &r.series.modelled[1]}) {
      for (size_t k = 0; k < torque->size(); ++k) (*torque)[k] += 5.0;
    }
  }
  add_friction(id.train[2], 1, 0.2, 0.5, 0.4);
  EXPECT_TRUE(find_snags(id, {}).empty());
  add_friction(id.train[2], 1, 0.2, 0.5, 2.0);
  EXPECT_EQ(find_snags(id, {}).size(), 1U);
}

// A spot is a part of the travel; what holds over half of it is friction of its own.
TEST(Snags, FrictionOverHalfOfTheTravelIsNoSpot) {
  for (const double to : {0.5, 0.8}) {
    Identification id = four_recordings();
    add_friction(id.train[2], 1, -0.2, to, 0.6);
    EXPECT_EQ(find_snags(id, {}).size(), to < 0.6 ? 1U : 0U) << to;
  }
}

TEST(Snags, OfASlideAreToldInMillimetres) {
  const Model arm = read_model("psm-3dof");
  const Snag snag{"one.csv", 2, 0.105, 0.121, 1.34};
  ASSERT_TRUE(arm.coordinates()[2].prismatic);
  const std::string text = snag_text(snag, arm.coordinates()[2]);
  EXPECT_NE(text.find("1.3 N more friction between 105 and 121 mm"), std::string::npos) << text;
  EXPECT_NE(snag_text(snag, arm.coordinates()[0]).find("1.3 N m more friction between 105 and 121 mrad"), std::string::npos);
}

}  // namespace
}  // namespace veridyn
