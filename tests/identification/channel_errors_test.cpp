#include "veridyn/effects/channel_effect.hpp"

#include <gtest/gtest.h>

#include "simulation/simulation_support.hpp"
#include "support/near.hpp"
#include "support/simulated.hpp"
#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/identification/regressor_columns.hpp"
#include "veridyn/simulation/plausible_model.hpp"

// Columns of channel errors and tilt against what the simulation records with a small one of them.

namespace veridyn {
namespace {

PreprocessingOptions unfiltered() {
  PreprocessingOptions o;
  o.cutoff = 0.0;
  o.drop_start = 0.5;
  o.drop_end = 0.5;
  return o;
}

EffectTerm term_of(const Model& arm, const std::string& effect, int joint) {
  EffectTerm term;
  term.effect = effect;
  term.axis.coefficients = VectorXd::Zero(arm.joints());
  if (joint >= 0) term.axis.coefficients[joint] = 1.0;
  if (channel_effect(effect)->traits().uses_source)
    term.from = Axis{VectorXd::Unit(arm.joints(), joint == 0 ? 1 : 0), 0.0};
  return term;
}

// Torques per joint, stacked, and the column of the effect's parameter p.
struct Rows {
  VectorXd tau;
  VectorXd column;
};

Rows rows_of_arm(const Model& arm, const EffectTerm& term, int p, const Recording& recording) {
  ModelDescription d = arm.description();
  d.effects.push_back(term);
  const Model asked(std::move(d));
  const std::string name = standard_parameters(asked)[standard_parameters(asked).size() - channel_effect(term.effect)->parameters().size() + static_cast<size_t>(p)].name;
  const RegressorColumns columns(asked, unfiltered());
  Rows out;
  for_each_segment(asked, recording, unfiltered(), [&](const Segment& s) {
    for (const JointRows& joint : columns.rows(s)) {
      VectorXd column = VectorXd::Zero(joint.b.size());
      for (size_t c = 0; c < joint.parameters.size(); ++c) {
        if (columns.parameters()[joint.parameters[c]].name == name)
          column = joint.A.col(c);
      }
      const Eigen::Index at = out.tau.size();
      out.tau.conservativeResize(at + joint.b.size());
      out.column.conservativeResize(at + joint.b.size());
      out.tau.tail(joint.b.size()) = joint.b;
      out.column.tail(joint.b.size()) = column;
    }
  });
  return out;
}

struct Case {
  const char* effect;
  int joint;
  int parameter;
  const char* hidden;  // with a size of kSize
  double size;
};

class ArmEffect : public testing::TestWithParam<Case> {};

INSTANTIATE_TEST_SUITE_P(
    Each, ArmEffect,
    testing::Values(Case{"torque_gain", 1, 0, "torque_gain:2:gain=1.0001", 1e-4},
                    Case{"torque_crosstalk", 1, 0, "torque_crosstalk:2:from=1,share=0.0001", 1e-4},
                    Case{"time_delay", 0, 0, "time_delay:1:seconds=0.0001", 1e-4},
                    Case{"encoder_offset", 1, 0, "encoder_offset:2:offset=0.0001", 1e-4},
                    Case{"gravity_tilt", -1, 0, "gravity_tilt:arm:roll=0.0001,pitch=0", 1e-4},
                    Case{"gravity_tilt", -1, 1, "gravity_tilt:arm:roll=0,pitch=0.0001", 1e-4}),
    [](const auto& test) {
      return std::string(test.param.effect) + std::to_string(test.param.parameter);
    });

TEST_P(ArmEffect, ColumnIsTheDerivativeOfTheRecordedTorque) {
  const Case c = GetParam();
  // Frictionless: a sign at rest would jump.
  ModelDescription d = plausible_model(read_model("elbow-6r"), 4).arm.description();
  d.effects.clear();
  const Model arm(std::move(d));
  const EffectTerm term = term_of(arm, c.effect, c.joint);
  // Torque and position as recorded with the error; the column is asked at those positions.
  const Recording clean = recording_of(simulated(arm, {}));
  Recording wrong = recording_of(simulated(arm, {c.hidden}));
  const Rows without = rows_of_arm(arm, term, c.parameter, clean);
  if (std::string(c.effect) == "encoder_offset") {
    // Seen through the wrong positions, the same torques are off by the column.
    wrong.tau = clean.tau;
    const TorqueRegressor batch(arm);
    MatrixXd at_wrong;
    MatrixXd at_right;
    const VectorXd phi = *arm.inertial_values();
    batch.torques(wrong.q, wrong.dq, simulated(arm, {}).measured.ddq, phi, at_wrong);
    batch.torques(clean.q, clean.dq, simulated(arm, {}).measured.ddq, phi, at_right);
    Recording change = clean;
    change.tau = (at_right - at_wrong) / c.size;
    const Rows expected = rows_of_arm(arm, term, c.parameter, change);
    EXPECT_LT((expected.tau - without.column).norm(), 2e-3 * without.column.norm());
    return;
  }
  const Rows with = rows_of_arm(arm, term, c.parameter, wrong);
  const VectorXd expected = (with.tau - without.tau) / c.size;
  EXPECT_GT(without.column.norm(), 0.0);
  // A delay of less than a sample is a straight line between two of them: half a step of its own.
  const double tolerance = std::string(c.effect) == "time_delay" ? 2e-2 : 2e-3;
  EXPECT_LT((expected - without.column).norm(), tolerance * without.column.norm());
}

TEST(ArmEffect, ChannelErrorsStoredInAModelAreCorrectedInItsRecordings) {
  ModelDescription d = plausible_model(read_model("scara"), 2).arm.description();
  d.effects.clear();
  const Model arm(std::move(d));
  const Recording wrong =
      recording_of(simulated(arm, {"torque_gain:1:gain=1.1", "time_delay:2:seconds=0.005",
                                   "encoder_offset:1:offset=0.02", "torque_crosstalk:3:from=1,share=0.07"}));
  const Recording clean = recording_of(simulated(arm, {}));
  Model aware = with_channel_error(arm, term_of(arm, "torque_gain", 0), {0.1});
  aware = with_channel_error(aware, term_of(arm, "time_delay", 1), {0.005});
  aware = with_channel_error(aware, term_of(arm, "encoder_offset", 0), {0.02});
  aware = with_channel_error(aware, term_of(arm, "torque_crosstalk", 2), {0.07});
  // The model's file stores the errors.
  aware = read_yaml(to_yaml(aware), "aware.yaml");
  const auto first = [](const Model& m, const Recording& r) {
    std::vector<Segment> all;
    for_each_segment(m, r, unfiltered(), [&all](const Segment& s) { all.push_back(s); });
    return all.front();
  };
  const Segment undone = first(aware, wrong);
  const Segment truth = first(arm, clean);
  EXPECT_TRUE(near(undone.q, truth.q, 1e-12));
  const Eigen::Index rows = undone.tau.rows() - 10;
  EXPECT_LT((undone.tau.topRows(rows) - truth.tau.topRows(rows)).norm(),
            1e-3 * truth.tau.topRows(rows).norm());
}

}  // namespace
}  // namespace veridyn
