#include "veridyn/diagnosis/payload.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "cli/tool.hpp"
#include "simulation/simulation_support.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/math/output_file.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/simulation/plausible_model.hpp"

// A point mass on a simulated arm whose own values are known exactly.

namespace veridyn {
namespace {

class Payload : public testing::Test {
 protected:
  Payload() : arm_(plausible_model(read_model("elbow-6r"), 4).arm) {}

  std::string recording_with(const std::string& hidden, unsigned seed) const {
    SimulationOptions options;
    options.hidden.push_back(parse_hidden_effect(hidden));
    options.noise = sensor_noise("dvrk");
    options.seed = seed;
    const SimulatedRecording s = simulate_recording(arm_, waves(arm_.joints(), 0.6), options);
    Recording r;
    r.time = s.measured.time;
    r.q = s.measured.q;
    r.dq = s.measured.dq;
    r.tau = s.tau;
    const std::string path = folder_.path("load" + std::to_string(seed) + ".csv");
    write_recording(r, path);
    return path;
  }

  Model arm_;
  TemporaryFolder folder_;
};

TEST_F(Payload, MassAndCentreOnTheLastLinkAreFound) {
  const std::string last = arm_.frames().back().name;
  const PayloadReport report = find_payload(
      arm_, {recording_with("payload:" + last + ":mass=1.5,x=0.05,y=-0.02,z=0.08", 1)});
  ASSERT_FALSE(report.links.empty());
  const PayloadEstimate& best = report.links.front();
  EXPECT_EQ(best.frame, last);
  EXPECT_NEAR(best.mass, 1.5, 0.075);
  EXPECT_LE(best.mass_low, 1.5);
  EXPECT_GE(best.mass_high, 1.5);
  EXPECT_NEAR(best.moment.x(), 1.5 * 0.05, 0.02);
  EXPECT_NEAR(best.moment.y(), 1.5 * -0.02, 0.02);
  EXPECT_NEAR(best.moment.z(), 1.5 * 0.08, 0.02);
  // What friction and offsets may do alone is told apart from what the load does.
  EXPECT_LT(report.error_with_drift.norm(), report.error_before.norm());
  EXPECT_LT(report.error_after.norm(), 0.5 * report.error_with_drift.norm());
  for (Eigen::Index i = 0; i < report.error_before.size(); ++i)
    EXPECT_LE(report.error_after[i], report.error_before[i] + 0.01);
}

// Ten free parameters of a body can follow a rotor's inertia; a load of whatever mass cannot.
TEST_F(Payload, ARotorsInertiaIsNotTakenForALoad) {
  const std::string hidden = "rotor_inertia:3:inertia=0.6";
  const Diagnosis d = diagnose(arm_, {recording_with(hidden, 3), recording_with(hidden, 4)},
                               {recording_with(hidden, 5)});
  ASSERT_FALSE(d.findings.empty());
  EXPECT_EQ(d.findings[0].effect, "rotor_inertia");
  EXPECT_EQ(d.findings[0].joint, 3);
  for (const Rival& r : d.findings[0].rivals) EXPECT_NE(r.effect, "payload") << r.frame;
}

TEST_F(Payload, OneLinkOnlyIfAskedSo) {
  const std::string last = arm_.frames().back().name;
  const std::string path = recording_with("payload:" + last + ":mass=1", 2);
  const PayloadReport report = find_payload(arm_, {path}, {}, last);
  ASSERT_EQ(report.links.size(), 1U);
  EXPECT_EQ(report.links[0].frame, last);
  EXPECT_THROW(find_payload(arm_, {path}, {}, "no_such_frame"), InvalidInput);
}

TEST_F(Payload, AnArmWithoutValuesIsRefused) {
  EXPECT_THROW(find_payload(read_model("psm-3dof"), {"none.csv"}), InvalidInput);
}

}  // namespace
}  // namespace veridyn
