#include <gtest/gtest.h>

#include <algorithm>

#include "simulation/simulation_support.hpp"
#include "support/simulated.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"

// Crosstalk between torque channels; torques at the limit of their channel.

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
  EXPECT_NEAR(d.extended.model->coordinates()[1].recorded.torque_crosstalk.at({0}), 0.15, 0.01);
  EXPECT_TRUE(d.extended.model->coordinates()[0].recorded.torque_crosstalk.empty());
}

// Crosstalk into the pitch biases parameters that both joints share, and so raises the error of the yaw.
TEST(TorqueCrosstalk, ExplainsTheErrorOfAJointWithSharedParameters) {
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

TEST(TorqueCrosstalk, IsNotNamedIfThereIsNone) {
  DiagnosisOptions asked;
  asked.effects = {"torque_crosstalk"};
  for (const DiagnosisOptions& how : {DiagnosisOptions(), asked})
    EXPECT_TRUE(diagnosed(truth(), "", how).findings.empty());
}

// The elbow's torque between limits of this share of its largest.
Diagnosis diagnosed_between_limits(double share) {
  std::vector<Recording> rows;
  double limit = 0.0;
  for (const unsigned seed : {1U, 2U, 3U}) {
    SimulationOptions options;
    options.noise = sensor_noise("low");
    options.seed = seed;
    rows.push_back(recording_of(simulate_recording(truth(), waves_of(seed), options)));
    rows.back().source = "run " + std::to_string(seed);
    if (seed == 1U) limit = share * rows[0].tau.col(1).cwiseAbs().maxCoeff();
    rows.back().tau.col(1) = rows.back().tau.col(1).cwiseMin(limit).cwiseMax(-limit).eval();
  }
  return diagnose(read_model("planar-2r"), {rows[0], rows[1]}, {rows[2]}, {});
}

bool report_contains(const Diagnosis& d, const std::string& words) {
  return std::any_of(d.remarks.begin(), d.remarks.end(),
                     [&words](const std::string& r) { return r.find(words) != std::string::npos; });
}

TEST(ATorqueAtItsLimit, IsLeftOutAndBiasesNothing) {
  const Diagnosis plain = diagnosed_between_limits(2.0);
  EXPECT_FALSE(report_contains(plain, "stands at its limit"));
  EXPECT_TRUE(plain.excluded_intervals.empty());
  const Diagnosis d = diagnosed_between_limits(0.7);
  EXPECT_TRUE(report_contains(d, "stands at its limit")) << d.report();
  EXPECT_TRUE(d.findings.empty()) << d.report();
  for (const ExcludedInterval& part : d.excluded_intervals) EXPECT_EQ(part.joint, JointIndex{1});
  const double recorded = d.baseline.test_error.relative[1];
  const double counted = d.baseline.test_without_excluded.relative[1];
  EXPECT_GT(recorded, 5.0 * counted);
  EXPECT_LT(counted, 2.0 * plain.baseline.test_error.relative[1]);
  EXPECT_DOUBLE_EQ(d.joints[1].held_out, counted);
  EXPECT_EQ(d.joints[1].state, JointState::kAtFloor) << d.report();
  EXPECT_LT(d.joints[0].held_out, 1.2 * plain.joints[0].held_out);
}

TEST(ATorqueAtItsLimit, IsKeptWithARemarkIfItIsThereMostOfTheTime) {
  const Diagnosis d = diagnosed_between_limits(0.1);
  EXPECT_TRUE(report_contains(d, "too much to be left out")) << d.report();
  for (const ExcludedInterval& part : d.excluded_intervals) EXPECT_NE(part.why, "torque at its limit");
}

}  // namespace
}  // namespace veridyn
