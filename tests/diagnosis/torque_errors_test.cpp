#include <gtest/gtest.h>

#include "simulation/simulation_support.hpp"
#include "support/simulated.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/model/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"

// Crosstalk between torque channels, asked about only where a joint's error depends on the torque of another one.

namespace veridyn {
namespace {

Diagnosis diagnosed(const Model& arm, const std::string& hidden, const DiagnosisOptions& how = {}) {
  std::vector<Recording> rows;
  for (const unsigned seed : {1U, 2U, 3U}) {
    SimulationOptions options;
    if (!hidden.empty()) options.hidden = {parse_hidden_effect(hidden)};
    options.noise = sensor_noise("low");
    options.seed = seed;
    rows.push_back(recording_of(simulate_recording(arm, waves_of(seed), options)));
    rows.back().source = "run " + std::to_string(seed);
  }
  return diagnose(read_model("planar-2r"), {rows[0], rows[1]}, {rows[2]}, how);
}

Model truth() {
  return plausible_model(read_model("planar-2r"), 2).arm;
}

TEST(TorqueCrosstalk, TakesThePlaceOfTheCurveOverTheOtherTorque) {
  const Diagnosis d = diagnosed(truth(), "torque_crosstalk:2:from=1,share=0.15");
  ASSERT_EQ(d.findings.size(), 1U) << d.report();
  const Finding& f = d.findings[0];
  EXPECT_EQ(to_text(truth(), f.cause), "torque_crosstalk:elbow");
  EXPECT_EQ(f.from, JointIndex{0});
  EXPECT_EQ(f.status, FindingStatus::kConfirmed);
  EXPECT_NEAR(f.parameters[0].value, 0.15, 0.01);
  EXPECT_NE(f.phrase.find("of joint 'shoulder'"), std::string::npos) << f.phrase;
  EXPECT_NEAR(d.extended.model->coordinates()[1].recorded.torque_crosstalk.at(0), 0.15, 0.01);
  EXPECT_TRUE(d.extended.model->coordinates()[0].recorded.torque_crosstalk.empty());
}

// What the channel of the pitch adds bends parameters that both joints share: the yaw is off before, and at its floor after.
TEST(TorqueCrosstalk, NamesTheErrorOfAJointThatItBends) {
  const Model arm = plausible_model(read_model("psm-3dof"), 2).arm;
  std::vector<Recording> rows;
  for (const unsigned seed : {1U, 2U, 3U}) {
    MotionSamples m{VectorXd::LinSpaced(4000, 0.0, 39.99), MatrixXd(4000, 3), {}, {}};
    for (int i = 0; i < 3; ++i)
      m.q.col(i) = (i == 2 ? 0.12 : 0.0) +
                   (i == 2 ? 0.1 : 1.0) * (0.5 * ((1.1 + 0.23 * i + 0.1 * seed) * m.time.array() + i * (1.0 + seed)).sin() +
                                           0.25 * ((2.9 - 0.31 * i) * m.time.array()).cos());
    SimulationOptions options;
    options.hidden = {parse_hidden_effect("torque_crosstalk:pitch:from=yaw,share=0.3")};
    options.noise = sensor_noise("low");
    options.seed = seed;
    rows.push_back(recording_of(simulate_recording(arm, with_derivatives(m), options)));
    rows.back().source = "run " + std::to_string(seed);
  }
  const Diagnosis d = diagnose(read_model("psm-3dof"), {rows[0], rows[1]}, {rows[2]}, {});
  ASSERT_EQ(d.findings.size(), 1U) << d.report();
  EXPECT_EQ(to_text(arm, d.findings[0].cause), "torque_crosstalk:pitch");
  const JointVerdict& yaw = d.joints[0];
  EXPECT_GT(yaw.held_out, 5.0 * yaw.floor);
  EXPECT_LT(yaw.extended, 1.1 * yaw.floor);
  EXPECT_EQ(yaw.state, JointState::kNamed) << yaw.why;
  EXPECT_EQ(d.joints[2].state, JointState::kAtFloor);
}

TEST(TorqueCrosstalk, IsNotThereWithoutIt) {
  DiagnosisOptions asked;
  asked.effects = {"torque_crosstalk"};
  for (const DiagnosisOptions& how : {DiagnosisOptions(), asked})
    EXPECT_TRUE(diagnosed(truth(), "", how).findings.empty());
}

}  // namespace
}  // namespace veridyn
