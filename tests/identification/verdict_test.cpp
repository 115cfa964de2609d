#include "veridyn/identification/verdict.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "identification/validation.hpp"
#include "veridyn/files/model_file.hpp"

// Joints in every state, and the words for them.

namespace veridyn {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// A result with these held-out errors and floors, of which every joint has used half of its range and speed.
Identification result(const std::vector<double>& errors, const std::vector<double>& floors) {
  Identification id;
  id.model = read_model("elbow-6r");
  const auto n = static_cast<Eigen::Index>(errors.size());
  id.test_error.relative = Eigen::Map<const VectorXd>(errors.data(), n);
  id.noise_floor = Eigen::Map<const VectorXd>(floors.data(), static_cast<Eigen::Index>(floors.size()));
  id.factors.resize(1);
  for (const Coordinate& c : id.model->coordinates()) {
    TorqueFacts facts;
    facts.lowest = c.limits.lower;
    facts.highest = 0.5 * (c.limits.lower + c.limits.upper);
    facts.largest_speed = 0.5 * c.limits.velocity;
    id.factors.front().joints.push_back(facts);
  }
  return id;
}

std::string name(const Identification& id, int joint) { return id.model->coordinates()[joint].name; }

TEST(TheVerdict, ListsTheStateOfEveryJoint) {
  Identification id = result({0.05, 0.009, 0.5, 30.0, std::numeric_limits<double>::infinity(), 0.3},
                             {0.03, 1e-6, 0.05, 0.01, 0.01, 0.3});
  TorqueFacts& hardly = id.factors.front().joints[5];
  const Limits& limits = id.model->coordinates()[5].limits;
  hardly.highest = hardly.lowest + 0.02 * (limits.upper - limits.lower);
  hardly.largest_speed = 0.03 * limits.velocity;
  const IdentificationVerdict v = verdict_of(id);
  ASSERT_EQ(v.joints.size(), 6U);
  EXPECT_TRUE(v.held_out);
  const char* states[] = {"at_floor", "at_floor", "unexplained", "unexplained", "no_torque", "hardly_moved"};
  for (int i = 0; i < 6; ++i) EXPECT_STREQ(name_of(v.joints[i].state), states[i]) << i;
  EXPECT_NEAR(v.joints[0].range, 0.5, 1e-12);
  EXPECT_NEAR(v.joints[0].speed, 0.5, 1e-12);
  EXPECT_EQ(v.sentence,
            name(id, 5) + " moved over 2 % of the range: record again with a motion of `veridyn excite`; " + name(id, 2) + " and " +
                name(id, 3) + " leave 10 and over 1000 times the noise held out: `veridyn diagnose` asks why; " + name(id, 4) +
                " has no torque held out: it was not recorded, or nothing drove the joint; " + name(id, 0) + " is at the noise (error 5 % held out); " +
                name(id, 1) + " leaves 0.9 % held out, more than the noise, less than most torque sensors resolve");
}

// Repetitions that differ by a fifth of the torque are no noise.
TEST(TheVerdict, DoesNotReportALargeDifferenceAsNoise) {
  for (const bool large : {false, true}) {
    const Identification id = result({large ? 0.2 : 0.02, 0.01, 0.01, 0.01, 0.01, 0.01}, {large ? 0.25 : 0.02, 0.01, 0.01, 0.01, 0.01, 0.01});
    const IdentificationVerdict v = verdict_of(id);
    EXPECT_EQ(v.joints[0].state, IdentifiedState::kAtFloor);
    EXPECT_EQ(v.sentence.find(name(id, 0) + " leaves 20 % held out, about what its repetitions differ by") != std::string::npos, large) << v.sentence;
    EXPECT_EQ(v.sentence.find("error 20 %"), std::string::npos) << v.sentence;
  }
}

// Rows that came late are no error of the model: where they are repaired, the repaired error decides.
TEST(TheVerdict, UsesTheErrorOfRepairedRowsIfGiven) {
  Identification id = result({0.1, 0.1, 0.1, 0.1, 0.1, 0.1}, {0.01, 0.01, 0.01, 0.01, 0.01, 0.01});
  EXPECT_EQ(verdict_of(id).joints[0].state, IdentifiedState::kUnexplained);
  id.test_repaired.relative = VectorXd::Constant(6, 0.011);
  EXPECT_EQ(verdict_of(id).joints[0].state, IdentifiedState::kAtFloor);
  EXPECT_NE(verdict_of(id).sentence.find("held out, late rows repaired"), std::string::npos);
}

// Without repeats the noise is not known, except that one per cent is better than any sensor; without limits no
// joint hardly moves; and a joint that moves slowly over its range, or quickly over little of it, moves.
TEST(TheVerdict, WithoutRepeatsOrLimitsNoJointStateIsDecided) {
  Identification id = result({0.2, 0.005, 0.2, 0.2, 0.2, 0.2}, {});
  id.train_error = id.test_error;
  id.test_error = {};
  id.factors.front().joints[2].largest_speed = 0.0;
  id.factors.front().joints[3].highest = id.factors.front().joints[3].lowest;
  ModelDescription d = id.model->description();
  d.coordinates[4].limits.upper = std::numeric_limits<double>::infinity();
  d.coordinates[4].limits.velocity = std::numeric_limits<double>::infinity();
  id.model = Model(std::move(d));
  const IdentificationVerdict v = verdict_of(id);
  EXPECT_FALSE(v.held_out);
  for (const int i : {0, 1, 2, 3, 4, 5}) EXPECT_EQ(v.joints[i].state, IdentifiedState::kCannotTell) << i;
  EXPECT_TRUE(std::isnan(v.joints[4].range) && std::isnan(v.joints[4].speed));
  EXPECT_NE(v.sentence.find("on the training recordings, and as no motion is repeated, the noise is not known"), std::string::npos)
      << v.sentence;
  id.noise_floor = VectorXd::Constant(6, kNan);
  id.noise_floor[1] = 1e-9;
  EXPECT_EQ(verdict_of(id).joints[0].state, IdentifiedState::kCannotTell);
  EXPECT_EQ(verdict_of(id).joints[1].state, IdentifiedState::kAtFloor);
}

TEST(TheVerdict, WithoutAModelIsEmpty) {
  const IdentificationVerdict none = verdict_of(Identification());
  EXPECT_TRUE(none.joints.empty());
  EXPECT_EQ(none.sentence, "");
  Identification bare;
  bare.model = read_model("planar-2r");
  EXPECT_EQ(verdict_of(bare).sentence, "");
}

// A contact in one recording does not repeat and is no noise; a recording without repetitions has no floor.
TEST(NoiseFloor, ExcludesARecordingWithAContact) {
  std::vector<CompressedRecording> recordings(4);
  recordings[0].noise_floor = Eigen::Vector2d(0.01, 0.03);
  recordings[1].noise_floor = Eigen::Vector2d(0.02, 0.04);
  recordings[2].noise_floor = Eigen::Vector2d(0.50, 0.05);
  const VectorXd floor = mean_noise_floor(recordings, 2);
  ASSERT_EQ(floor.size(), 2);
  EXPECT_NEAR(floor[0], std::sqrt((0.0001 + 0.0004) / 2.0), 1e-12);
  EXPECT_NEAR(floor[1], std::sqrt((0.0009 + 0.0016 + 0.0025) / 3.0), 1e-12);
  EXPECT_EQ(mean_noise_floor({CompressedRecording()}, 2).size(), 0);
}

}  // namespace
}  // namespace veridyn
