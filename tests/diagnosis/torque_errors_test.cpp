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
  return diagnose(read_model(arm.name()), {rows[0], rows[1]}, {rows[2]}, how);
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

// The fit bends the parameters of one joint to what another joint's channel adds.
TEST(TorqueCrosstalk, NamesTheErrorOfAJointThatItBends) {
  const Model arm = truth();
  const Diagnosis d = diagnosed(arm, "torque_crosstalk:2:from=1,share=0.15");
  std::cout << d.report() << std::endl;
  for (const JointVerdict& v : d.joints) std::cout << v.held_out << " " << v.floor << " " << v.extended << " " << static_cast<int>(v.state) << std::endl;
}

TEST(TorqueCrosstalk, IsNotThereWithoutIt) {
  DiagnosisOptions asked;
  asked.effects = {"torque_crosstalk"};
  for (const DiagnosisOptions& how : {DiagnosisOptions(), asked})
    EXPECT_TRUE(diagnosed(truth(), "", how).findings.empty());
}

}  // namespace
}  // namespace veridyn
