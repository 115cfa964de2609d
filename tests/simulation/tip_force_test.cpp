#include <gtest/gtest.h>

#include <algorithm>

#include "math/zero_phase_filter.hpp"
#include "simulation/simulation_support.hpp"
#include "support/near.hpp"
#include "support/simulated.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/engine.hpp"
#include "veridyn/simulation/joint_torques.hpp"
#include "veridyn/simulation/plausible_model.hpp"

// A force of constant direction at the end of the arm.

namespace veridyn {
namespace {

Model bare() {
  ModelDescription d = plausible_model(read_model("planar-2r"), 2).arm.description();
  d.effects.clear();
  return Model(std::move(d));
}

Model pulled(const std::string& values) {
  return inject_effects(bare(), {parse_hidden_effect("tip_force:arm:" + values)}).arm;
}

// The tip of two rods of 0.5 and 0.4 m in a plane.
TEST(TipForce, IsTheTransposedJacobianTimesTheForce) {
  const int rows = 40;
  MotionSamples m{VectorXd::LinSpaced(rows, 0.0, 0.39), MatrixXd::Random(rows, 2), MatrixXd::Zero(rows, 2), MatrixXd::Zero(rows, 2)};
  const MatrixXd more = joint_torques(pulled("x=2,y=-3,z=7"), m) - joint_torques(bare(), m);
  for (int r = 0; r < rows; ++r) {
    const double a = m.q(r, 0), b = m.q(r, 0) + m.q(r, 1);
    const double fore = -0.4 * std::sin(b) * 2.0 + 0.4 * std::cos(b) * -3.0;
    EXPECT_NEAR(more(r, 1), -fore, 1e-9);
    EXPECT_NEAR(more(r, 0), -(fore - 0.5 * std::sin(a) * 2.0 + 0.5 * std::cos(a) * -3.0), 1e-9);
  }
}

TEST(TipForce, IsWrittenToFilesAndReportedIfAnEngineOmitsIt) {
  const Model arm = pulled("x=2,y=0,z=0");
  const Model again = read_yaml(to_yaml(arm), "again");
  ASSERT_EQ(again.arm_effects().size(), 1U);
  EXPECT_EQ(again.arm_effects()[0].values, arm.arm_effects()[0].values);
  const std::vector<std::string> left_out = make_engine("veridyn", arm)->left_out();
  ASSERT_EQ(left_out.size(), 1U);
  EXPECT_EQ(left_out[0], "tip_force on the arm: it acts at a frame and along no axis");
}

TEST(TipForce, IsDiagnosedOnlyIfPresent) {
  for (const bool there : {true, false}) {
    std::vector<Recording> rows;
    for (const unsigned seed : {1U, 2U, 3U}) {
      SimulationOptions options;
      if (there) options.hidden = {parse_hidden_effect("tip_force:arm:x=6,y=4,z=0")};
      options.noise = sensor_noise("low");
      options.seed = seed;
      rows.push_back(recording_of(simulate_recording(bare(), waves_of(seed), options)));
      rows.back().source = "run " + std::to_string(seed);
    }
    DiagnosisOptions options;
    options.effects = {"tip_force", "joint_spring", "position_force", "torque_offset", "cable_coupling"};
    const Diagnosis d = diagnose(bare(), {rows[0], rows[1]}, {rows[2]}, options);
    if (!there) {
      EXPECT_TRUE(d.findings.empty()) << d.report();
      continue;
    }
    ASSERT_FALSE(d.findings.empty());
    EXPECT_EQ(to_text(bare(), d.findings[0].cause), "tip_force:arm") << d.report();
    EXPECT_EQ(d.findings.size(), 1U) << d.report();
    EXPECT_NEAR(d.findings[0].parameters[0].value, 6.0, 0.3);
    EXPECT_NEAR(d.findings[0].parameters[1].value, 4.0, 0.3);
  }
}

}  // namespace
}  // namespace veridyn
