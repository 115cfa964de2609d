#include "identification/velocity_choice.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "identification/identification_numbers.hpp"
#include "identification/synthetic_recording.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

const Model& arm() {
  static const Model kArm = read_model(VERIDYN_SOURCE_DIR "/data/robots/planar-2r.yaml");
  return kArm;
}

Recording recording() {
  MotionShape shape;
  shape.duration = 30.0;
  Recording r = synthetic_recording(arm(), shape);
  r.tau += noise_like(r.tau, 0.02, 3);
  return r;
}

// A velocity that goes in steps of this share of its range.
void quantise(Recording& r, int joint, double share) {
  auto dq = r.dq.col(joint);
  const double step = share * (dq.maxCoeff() - dq.minCoeff());
  for (double& x : dq) x = std::round(x / step) * step;
}

std::vector<JointIndex> derived(const Recording& r, bool choose = true) {
  IdentificationOptions options;
  options.choose_velocities = choose;
  const Identification id = identify(arm(), r, options);
  EXPECT_EQ(id.remarks.size(), id.preprocessing.derive_velocity_of.size());
  return id.preprocessing.derive_velocity_of;
}

double distance(const Recording& r, bool choose) {
  IdentificationOptions options;
  options.choose_velocities = choose;
  return (identify(arm(), r, options).parameters - true_parameters(arm())).norm();
}

TEST(VelocityChoice, ConsistentVelocitiesAreUsedAsRecorded) {
  EXPECT_TRUE(derived(recording()).empty());
}

TEST(VelocityChoice, OnlyTheJointWithACoarseVelocityUsesThePosition) {
  Recording r = recording();
  quantise(r, 1, 0.1);
  EXPECT_EQ(derived(r), (std::vector<JointIndex>{{1}}));
  EXPECT_TRUE(derived(r, false).empty());
  quantise(r, 0, 0.1);
  EXPECT_EQ(derived(r), (std::vector<JointIndex>{{0}, {1}}));
  EXPECT_LT(distance(r, true), distance(r, false));
}

// The same rule without a fit: the error of a model must not be that of a velocity in degrees.
TEST(VelocityChoice, AWrongVelocityIsNotReportedAsAModelError) {
  Recording r = recording();
  const Identification good = identify(arm(), r);
  ASSERT_TRUE(good.model.has_value());
  const double honest = evaluate(*good.model, r).train_error.relative.maxCoeff();
  r.dq.col(0) *= 180.0 / M_PI;
  const Identification judged = evaluate(*good.model, r);
  EXPECT_EQ(judged.preprocessing.derive_velocity_of, (std::vector<JointIndex>{{0}}));
  EXPECT_LT(judged.train_error.relative.maxCoeff(), 1.2 * honest);
  IdentificationOptions as_recorded;
  as_recorded.choose_velocities = false;
  EXPECT_GT(evaluate(*good.model, r, {}, as_recorded).train_error.relative.maxCoeff(), 2.0 * honest);
}

// Published identifications filter the signals and take the velocity as it is; to compare with them
// this must too.
TEST(VelocityChoice, WithFilteredSignalsTheRecordedVelocityIsUsed) {
  Recording r = recording();
  quantise(r, 1, 0.1);
  IdentificationOptions options;
  options.preprocessing.filtering = Filtering::kSignals;
  EXPECT_TRUE(identify(arm(), r, options).preprocessing.derive_velocity_of.empty());
  options.preprocessing.filtering = Filtering::kMatched;
  EXPECT_FALSE(identify(arm(), r, options).preprocessing.derive_velocity_of.empty());
}

TEST(VelocityChoice, AVelocityOfAnotherUnitIsReplacedByTheDerivedOne) {
  Recording r = recording();
  r.dq.col(0) *= 1.2;
  EXPECT_EQ(derived(r), (std::vector<JointIndex>{{0}}));
}

// Velocities are judged from the rows that are asked about, and from a bounded number of them.
TEST(VelocityChoice, InspectedRowsAreThoseOfTheOptionsUpToABound) {
  PreprocessingOptions how;
  how.first_row = 7;
  how.row_count = 30;
  EXPECT_EQ(inspected_rows(arm(), how).first_row, 7);
  EXPECT_EQ(inspected_rows(arm(), how).row_count, 30);
  how.row_count = identifying::kLookedAt + 1;
  EXPECT_EQ(inspected_rows(arm(), how).row_count, identifying::kLookedAt);
  how.row_count.reset();
  EXPECT_EQ(inspected_rows(arm(), how).row_count, identifying::kLookedAt);
}

// The torques are the judge: a position that is worse than the doubtful velocity is not asked.
TEST(VelocityChoice, VelocitiesAreReplacedOnlyWhereTheTorqueErrorFalls) {
  Identification before;
  before.train_error.relative = Eigen::Vector3d(0.10, 0.10, 0.10);
  std::vector<std::set<JointIndex>> asked;
  const auto look = [&](const std::set<JointIndex>& joints) {
    asked.push_back(joints);
    Identification id;
    id.model = arm();
    id.train_error.relative = Eigen::Vector3d(0.09, 0.11, 0.099);  // better, worse, not worth it
    return id;
  };
  const VelocityChoice some = choose_velocities(before, {{0}, {1}, {2}}, identifying::numbers.velocity_gain, look);
  EXPECT_EQ(some.better, (std::set<JointIndex>{{0}}));
  EXPECT_TRUE(some.fit.has_value());
  EXPECT_EQ(asked, (std::vector<std::set<JointIndex>>{{{0}, {1}, {2}}, {{0}}}));
  const VelocityChoice none = choose_velocities(before, {{1}, {2}}, identifying::numbers.velocity_gain, look);
  EXPECT_TRUE(none.better.empty());
  EXPECT_FALSE(none.fit.has_value());
  EXPECT_FALSE(choose_velocities(before, {}, identifying::numbers.velocity_gain, look).fit.has_value());
}

}  // namespace
}  // namespace veridyn
