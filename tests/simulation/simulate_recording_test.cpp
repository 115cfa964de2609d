#include "veridyn/simulation/simulate_recording.hpp"

#include <gtest/gtest.h>

#include "simulation_support.hpp"
#include "support/near.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// Written out again from the formulas, one state at a time.
TEST(SimulateRecording, IdealTorquesAreInverseDynamicsPlusEffects) {
  for (const char* robot : {"planar-2r", "scara", "elbow-6r"}) {
    const Model arm = read_model(robot);
    const SimulatedRecording s = simulated(arm, {});
    for (const Eigen::Index k : {Eigen::Index{0}, Eigen::Index{77}, Eigen::Index{2000}}) {
      VectorXd tau =
          inverse_dynamics(arm, s.measured.q.row(k).transpose(), s.measured.dq.row(k).transpose(),
                           s.measured.ddq.row(k).transpose());
      for (const EffectTerm& term : arm.effects()) {
        const int i = main_coordinate(term.axis).value;
        const double v = s.measured.dq(k, i);
        if (term.effect == "rotor_inertia")
          tau[i] += term.values.at("inertia") * s.measured.ddq(k, i);
        if (term.effect == "viscous_friction") tau[i] += term.values.at("coefficient") * v;
        if (term.effect == "coulomb_friction")
          tau[i] += term.values.at("level") * ((v > 0.0) - (v < 0.0));
      }
      EXPECT_TRUE(near(s.tau.row(k).transpose(), tau, 1e-12 * (1.0 + tau.norm())))
          << robot << ", row " << k;
    }
  }
}

TEST(SimulateRecording, WithoutNoiseTheRecordingIsTheWantedMotion) {
  const Model arm = read_model("scara");
  const SimulatedRecording s = simulated(arm, {});
  EXPECT_TRUE(near(s.measured.q, waves(4).q, 0.0));
  EXPECT_TRUE(near(s.measured.dq, waves(4).dq, 0.0));
  EXPECT_TRUE(near(s.tau, s.actual_tau, 0.0));
}

TEST(SimulateRecording, TheSameSeedGivesTheSameRecording) {
  const Model arm = read_model("planar-2r");
  SimulationOptions options;
  options.noise = sensor_noise("dvrk");
  const SimulatedRecording one = simulate_recording(arm, waves(2), options);
  const SimulatedRecording again = simulate_recording(arm, waves(2), options);
  options.seed = 2;
  const SimulatedRecording other = simulate_recording(arm, waves(2), options);
  EXPECT_TRUE(near(one.tau, again.tau, 0.0));
  EXPECT_TRUE(near(one.measured.q, again.measured.q, 0.0));
  EXPECT_GT((one.tau - other.tau).norm(), 0.0);
}

TEST(SimulateRecording, RefusesMotionsThatDoNotFit) {
  const Model arm = read_model("planar-2r");
  EXPECT_THROW(simulate_recording(arm, waves(3)), InvalidInput);
  MotionSamples back = waves(2);
  back.time[5] = back.time[4];
  EXPECT_THROW(simulate_recording(arm, back), InvalidInput);
  MotionSamples gap = waves(2);
  gap.q(3, 1) = std::nan("");
  EXPECT_THROW(simulate_recording(arm, gap), InvalidInput);
  EXPECT_THROW(simulate_recording(read_model("psm-3dof"), waves(3)), InvalidInput);
}

TEST(WithDerivatives, ComputesMissingDerivatives) {
  const MotionSamples full = waves(2);
  const MotionSamples derived = with_derivatives({full.time, full.q, {}, {}});
  // Fourth-order differences: h^4 / 30 of the fifth derivative, and lower orders at the ends.
  EXPECT_TRUE(near(derived.dq.middleRows(5, 1990), full.dq.middleRows(5, 1990), 1e-8));
  EXPECT_TRUE(near(derived.ddq.middleRows(5, 1990), full.ddq.middleRows(5, 1990), 1e-7));
  MotionSamples uneven{full.time, full.q, {}, {}};
  uneven.time.tail(1000).array() += 0.1;
  EXPECT_THROW(with_derivatives(uneven), InvalidInput);
}

}  // namespace
}  // namespace veridyn
