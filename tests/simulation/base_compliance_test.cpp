#include <gtest/gtest.h>

#include "math/zero_phase_filter.hpp"
#include "simulation/simulation_support.hpp"
#include "support/near.hpp"
#include "support/simulated.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/engine.hpp"
#include "veridyn/simulation/joint_torques.hpp"
#include "veridyn/simulation/plausible_model.hpp"
#include "veridyn/simulation/simulate_controlled.hpp"

// A base that gives way: its columns (a derivative, along a motion) and its states (joints with
// springs, in an engine) are two codes of one thing.

namespace veridyn {
namespace {

constexpr double kCompliance = 1e-4;  // [rad/(N m)]

// Without dry friction, whose jumps a derivative cannot follow.
Model stiff() {
  ModelDescription d = plausible_model(read_model("elbow-6r"), 2).arm.description();
  d.effects.clear();
  return Model(std::move(d));
}

Model on_soft_base(double about_x, double about_y) {
  const auto hidden = parse_hidden_effect("base_compliance:arm:about_x=" + std::to_string(about_x) +
                                          ",about_y=" + std::to_string(about_y));
  return inject_effects(stiff(), {hidden}).arm;
}

MotionSamples slow_waves(int rows, double dt, unsigned seed = 0) {
  MotionSamples m{VectorXd::LinSpaced(rows, 0.0, dt * (rows - 1)), MatrixXd(rows, 6), {}, {}};
  for (int i = 0; i < 6; ++i)
    m.q.col(i) = 0.4 + 0.3 * ((1.0 + 0.2 * i) * m.time.array() + i * (1.0 + seed)).sin();
  return with_derivatives(m);
}

TEST(BaseCompliance, IsKeptByARobotFileAndAddsTwoCoordinates) {
  const Model soft = on_soft_base(2e-4, 1e-4);
  ASSERT_EQ(soft.arm_effects().size(), 1U);
  EXPECT_DOUBLE_EQ(soft.arm_effects()[0].values.at("about_x"), 2e-4);
  const Model again = read_yaml(to_yaml(soft), "again");
  ASSERT_EQ(again.arm_effects().size(), 1U);
  EXPECT_EQ(again.arm_effects()[0].effect, "base_compliance");
  EXPECT_EQ(again.arm_effects()[0].values, soft.arm_effects()[0].values);
  EXPECT_EQ(with_arm_states(soft).joints(), 8);
  EXPECT_EQ(with_arm_states(stiff()).joints(), 6);
}

// At rest the columns times the compliance are what an engine in balance needs beyond the stiff arm,
// to second order in the turn of the base.
TEST(BaseCompliance, ColumnsEqualTheExtraTorquesOfAnElasticBaseAtRest) {
  const VectorXd q = VectorXd::LinSpaced(6, 0.2, 0.8), rest = VectorXd::Zero(6);
  double before = 0.0;
  for (const double c : {2.0 * kCompliance, kCompliance}) {
    const Model soft = on_soft_base(c, c);
    const auto engine = make_engine("veridyn", soft);
    engine->set_state(q, rest);
    MotionSamples still{VectorXd::LinSpaced(9, 0.0, 0.08), q.transpose().replicate(9, 1),
                        MatrixXd::Zero(9, 6), MatrixXd::Zero(9, 6)};
    const VectorXd hold = joint_torques(soft, still).row(4).transpose();
    const VectorXd extra = hold - joint_torques(stiff(), still).row(4).transpose();
    EXPECT_GT(extra.norm(), 1e-3 * hold.norm());
    // The torque that is still missing, by the acceleration that it makes.
    VectorXd ddq(6), unloaded(6);
    ASSERT_EQ(engine->accelerate(hold, ddq), StepStatus::kOk);
    const VectorXd stiffly = hold - extra;
    ASSERT_EQ(engine->accelerate(stiffly, unloaded), StepStatus::kOk);
    const double left = ddq.norm() / unloaded.norm();
    EXPECT_LT(left, 0.05);
    if (before > 0.0) {
      EXPECT_NEAR(left / before, 0.5, 0.1);
    }
    before = left;
  }
}

// In motion, below the resonance of arm and base (7 Hz): what the motors of a controlled arm gave
// beyond the stiff arm's torques, beside what the columns say of its motion.
TEST(BaseCompliance, ColumnsEqualTheExtraTorquesOfAnElasticBaseInMotion) {
  constexpr double kStep = 0.005;  // [s]
  ControlledOptions options;
  options.recording.hidden = {parse_hidden_effect("base_compliance:arm:about_x=1e-4,about_y=1e-4")};
  const ControlledRecording run = simulate_controlled(stiff(), slow_waves(4000, kStep), options);
  ASSERT_TRUE(run.run.complete());
  EXPECT_TRUE(run.left_out.empty());
  const MotionSamples& m = run.recording.actual;
  const MatrixXd without = joint_torques(stiff(), m);
  const auto slow = [&](MatrixXd tau) {
    ZeroPhaseFilter(2.0, 4, 1.0 / kStep).apply(tau);
    return MatrixXd(tau.middleRows(1000, 2500));  // once it no longer swings from the start
  };
  const MatrixXd real = slow(run.recording.actual_tau - without);
  const MatrixXd columns = slow(joint_torques(run.recording.truth, m) - without);
  EXPECT_GT(real.norm(), 1e-3 * slow(without).norm());
  EXPECT_LT((real - columns).norm(), 0.2 * real.norm());
}

// From recordings of an arm whose base truly swings, by name; nothing where the base stands firm.
TEST(BaseCompliance, IsIdentifiedFromASimulatedRecording) {
  const auto diagnosed = [](const std::vector<HiddenEffect>& hidden) {
    std::vector<Recording> rows;
    for (const unsigned seed : {1U, 2U}) {
      ControlledOptions options;
      options.recording.hidden = hidden;
      options.recording.noise = sensor_noise("low");
      options.recording.seed = seed;
      rows.push_back(recording_of(
          simulate_controlled(stiff(), slow_waves(6000, 0.005, seed), options).recording));
      rows.back().source = "run " + std::to_string(seed);
    }
    DiagnosisOptions options;
    options.effects = {"base_compliance"};
    return diagnose(stiff(), {rows[0]}, {rows[1]}, options);
  };
  const Diagnosis soft =
      diagnosed({parse_hidden_effect("base_compliance:arm:about_x=1e-4,about_y=2e-4")});
  ASSERT_EQ(soft.findings.size(), 1U);
  EXPECT_EQ(to_text(stiff(), soft.findings[0].cause), "base_compliance:arm");
  ASSERT_EQ(soft.findings[0].parameters.size(), 2U);
  EXPECT_NEAR(soft.findings[0].parameters[0].value, 1e-4, 2e-5);
  EXPECT_NEAR(soft.findings[0].parameters[1].value, 2e-4, 2e-5);
  ASSERT_TRUE(soft.extended.model.has_value());
  EXPECT_EQ(soft.extended.model->arm_effects().size(), 1U);
  EXPECT_TRUE(diagnosed({}).findings.empty());
}

TEST(BaseCompliance, AComplianceBelowZeroIsRefused) {
  EXPECT_THROW(on_soft_base(-1e-4, 0.0), InvalidInput);
}

}  // namespace
}  // namespace veridyn
