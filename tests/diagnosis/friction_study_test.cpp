#include "support/simulated.hpp"
#include "veridyn/diagnosis/friction_study.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "recordings/steady_runs.hpp"
#include "simulation/simulation_support.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/simulation/plausible_model.hpp"

// One joint of a simulated arm at constant speeds in both directions, while the others rest.

namespace veridyn {
namespace {

constexpr double kRate = 100.0;         // [Hz]
constexpr double kStretch = 3.0;        // [s] in one direction
constexpr double kTurning = 0.25;       // [s] from rest to the speed
constexpr double kSpeeds[] = {0.05, 0.1, 0.2, 0.35};  // [rad/s]

MotionSamples constant_speeds(int joints, int repeats) {
  const int count = repeats * 2 * 4, each = static_cast<int>(kStretch * kRate);
  const Eigen::Index rows = count * each;
  MotionSamples m{VectorXd::LinSpaced(rows, 0.0, static_cast<double>(rows - 1) / kRate), MatrixXd::Zero(rows, joints),
                  MatrixXd::Zero(rows, joints), MatrixXd::Zero(rows, joints)};
  double q = 0.0;
  for (Eigen::Index k = 0; k < rows; ++k) {
    const auto segment = static_cast<int>(k / each);
    const double v = (segment % 2 == 0 ? 1.0 : -1.0) * kSpeeds[(segment / 2) % 4];
    const double t = static_cast<double>(k % each) / kRate;
    const double edge = std::min({t, kStretch - t, kTurning}) / kTurning;
    const double rising = t < kTurning ? 1.0 : t > kStretch - kTurning ? -1.0 : 0.0;
    m.q(k, 0) = q;
    m.dq(k, 0) = v * 0.5 * (1.0 - std::cos(M_PI * edge));
    m.ddq(k, 0) = rising * v * 0.5 * M_PI / kTurning * std::sin(M_PI * edge);
    q += m.dq(k, 0) / kRate;
  }
  return m;
}

class OneJoint : public testing::Test {
 protected:
  OneJoint() : arm_(plausible_model(read_model("psm-3dof"), 1).arm) {}

  // The yaw rests under a torque that grows by `breakaway`, and then slides: twice forwards, once backwards.
  Recording ramps(double breakaway) const {
    const int resting = static_cast<int>(2.0 * kRate), sliding = static_cast<int>(0.5 * kRate);
    Recording r;
    r.source = "ramps";
    const Eigen::Index rows = 3 * (resting + sliding);
    r.time = VectorXd::LinSpaced(rows, 0.0, static_cast<double>(rows - 1) / kRate);
    r.q = r.dq = r.tau = MatrixXd::Zero(rows, 3);
    RigidBodyDynamics bodies(arm_, *arm_.inertial_values());
    VectorXd holding(3);
    double q = 0.0;
    for (Eigen::Index k = 0; k < rows; ++k) {
      const auto within = static_cast<int>(k % (resting + sliding));
      const double direction = k / (resting + sliding) < 2 ? 1.0 : -1.0;
      const bool slides = within >= resting;
      r.dq(k, 0) = slides ? 0.3 * direction : 0.0;
      q += r.dq(k, 0) / kRate;
      r.q(k, 0) = q;
      bodies.gravity_torques(r.q.row(k).transpose(), holding);
      holding[0] += parameter("torque_offset", "offset");
      r.tau.row(k) = holding.transpose();
      r.tau(k, 0) += direction * breakaway * (slides ? 0.9 : static_cast<double>(within) / resting);
    }
    return r;
  }

  // Recordings with these hidden effects, studied with the robot file without values.
  FrictionStudy study(const std::vector<std::string>& hidden, const Model& asked, std::vector<Recording> recordings = {}) const {
    for (unsigned seed : {1u, 2u}) {
      SimulationOptions options;
      for (const std::string& one : hidden) options.hidden.push_back(parse_hidden_effect(one));
      options.noise = sensor_noise("low");
      options.seed = seed;
      const SimulatedRecording s = simulate_recording(arm_, constant_speeds(3, 2), options);
      Recording r = recording_of(s);
      r.source = "run " + std::to_string(seed);
      recordings.push_back(std::move(r));
    }
    return study_friction(asked, recordings);
  }

  double parameter(const std::string& effect, const std::string& name) const {
    for (const EffectTerm& term : arm_.effects())
      if (term.effect == effect && term.axis.coefficients[0] == 1.0) return term.values.at(name);
    return 0.0;
  }

  Model arm_;
};

const FrictionVerdict* find(const FrictionStudy& study, const std::string& effect) {
  for (const FrictionVerdict& v : study.joints.front().verdicts)
    if (v.effect == effect) return &v;
  return nullptr;
}

TEST_F(OneJoint, TheCurveIsTheFrictionOfTheArmAndJointsAtRestAreLeftOut) {
  const FrictionStudy found = study({}, read_model("psm-3dof"));
  ASSERT_EQ(found.reason, "");
  EXPECT_EQ(found.resting, (std::vector<std::string>{"insertion", "pitch"}));
  ASSERT_EQ(found.joints.size(), 1u);
  const JointFrictionStudy& yaw = found.joints.front();
  EXPECT_EQ(yaw.joint.value, 0);
  EXPECT_EQ(yaw.coordinate, "yaw");
  const double level = parameter("coulomb_friction", "level");
  const double viscous = parameter("viscous_friction", "coefficient");
  ASSERT_GT(level, 0.0);
  for (Eigen::Index k = 0; k < yaw.curve.velocity.size(); ++k) {
    const double v = yaw.curve.velocity[k];
    EXPECT_NEAR(yaw.curve.torque[k], (v > 0.0 ? level : -level) + viscous * v, 0.05 * level) << v;
  }
  ASSERT_EQ(yaw.speeds.size(), 8u);
  for (const FrictionAtSpeed& s : yaw.speeds) {
    EXPECT_NEAR(s.torque, yaw.curve.at(s.velocity), 0.05 * level) << s.velocity;
    EXPECT_GE(s.runs, 2);
  }
  for (const FrictionVerdict& v : yaw.verdicts) EXPECT_NE(v.state, FrictionState::kConfirmed) << v.effect;
}

TEST_F(OneJoint, HiddenFrictionIsConfirmed) {
  const FrictionStudy found = study({"position_dependent_friction:yaw:slope=0.3"}, read_model("psm-3dof"));
  ASSERT_EQ(found.joints.size(), 1u);
  const FrictionVerdict* verdict = find(found, "position_dependent_friction");
  ASSERT_NE(verdict, nullptr);
  EXPECT_EQ(verdict->state, FrictionState::kConfirmed) << found.report();
  EXPECT_FALSE(verdict->parameters.empty());
  EXPECT_LT(found.joints.front().error, 0.7 * found.joints.front().error_plain);
}

// A torque that comes late lags at each reversal, as behind a gap in the gear.
TEST_F(OneJoint, ALateTorqueIsNoBacklash) {
  const FrictionStudy found = study({"time_delay:yaw:seconds=0.06"}, read_model("psm-3dof"));
  ASSERT_EQ(found.joints.size(), 1u);
  const FrictionVerdict *late = find(found, "time_delay"), *gap = find(found, "backlash");
  ASSERT_NE(late, nullptr) << found.report();
  EXPECT_EQ(late->state, FrictionState::kConfirmed) << found.report();
  EXPECT_TRUE(gap == nullptr || gap->state != FrictionState::kConfirmed) << found.report();
  const double level = parameter("coulomb_friction", "level");
  EXPECT_NEAR(found.joints.front().curve.at(0.2), level + 0.2 * parameter("viscous_friction", "coefficient"), 0.05 * level);
}

TEST_F(OneJoint, BodiesOfAModelAreKeptAndItsFrictionIsEstimated) {
  ModelDescription d = arm_.description();
  for (EffectTerm& term : d.effects)
    for (auto& [name, value] : term.values) value *= 2.0;
  const FrictionStudy found = study({}, Model(std::move(d)));
  ASSERT_EQ(found.reason, "");
  const double level = parameter("coulomb_friction", "level");
  EXPECT_NEAR(found.joints.front().curve.at(0.1),
              level + 0.1 * parameter("viscous_friction", "coefficient"), 0.05 * level);
}

TEST_F(OneJoint, RecordingsWithoutMotionGiveAReason) {
  Recording still;
  still.source = "still";
  still.time = VectorXd::LinSpaced(1000, 0.0, 9.99);
  still.q = still.dq = still.tau = MatrixXd::Zero(1000, 3);
  const FrictionStudy found = study_friction(arm_, still);
  EXPECT_NE(found.reason, "");
  EXPECT_TRUE(found.joints.empty());
}

// The recordings contain no steady motion.
TEST_F(OneJoint, BreakawaysAreTorquesBeyondGravityWithTheirDirection) {
  constexpr double breakaway = 20.0;  // [N m], far beyond what holds the joint
  const FrictionStudy found = study({}, read_model("psm-3dof"), {ramps(breakaway)});
  ASSERT_EQ(found.joints.size(), 1u) << found.reason;
  const std::vector<FrictionBreakaway>& all = found.joints.front().breakaways;
  ASSERT_EQ(all.size(), 3u);
  for (size_t k = 0; k < all.size(); ++k) {
    EXPECT_EQ(all[k].source, "ramps");
    EXPECT_EQ(all[k].direction, k < 2 ? 1 : -1);
    EXPECT_NEAR(all[k].torque, (k < 2 ? 1.0 : -1.0) * breakaway, 0.1 * breakaway);
    EXPECT_NEAR(all[k].time, 2.0 + 2.5 * static_cast<double>(k), 0.1);
  }
  EXPECT_NE(found.report().find("breaks away forwards at +"), std::string::npos) << found.report();
  EXPECT_NE(found.report().find("breaks away backwards at -"), std::string::npos) << found.report();
  const FrictionStudy alone = study_friction(read_model("psm-3dof"), ramps(breakaway));
  EXPECT_NE(alone.reason.find("rest during most of their time"), std::string::npos) << alone.reason;
  EXPECT_NE(alone.report().find("no friction curve: all recordings rest"), std::string::npos) << alone.report();
}

// Of a single recording the last third is held out; given test recordings are used as a whole.
TEST_F(OneJoint, TheReportNamesTheHeldOutRows) {
  std::vector<Recording> recordings;
  for (unsigned seed : {1u, 2u}) {
    SimulationOptions options;
    options.noise = sensor_noise("low");
    options.seed = seed;
    recordings.push_back(recording_of(simulate_recording(arm_, constant_speeds(3, 2), options)));
    recordings.back().source = "run " + std::to_string(seed);
  }
  DiagnosisOptions options;
  options.effects = {"quadratic_drag"};
  EXPECT_EQ(study_friction(arm_, recordings[0], {}, options).held_out, std::vector<std::string>{"run 1 (its last third)"});
  EXPECT_EQ(study_friction(arm_, recordings[0], recordings[1], options).held_out, std::vector<std::string>{"run 2"});
  EXPECT_EQ(study_friction(arm_, recordings, {}, options).held_out, std::vector<std::string>{"run 2"});
}

TEST(SteadyRuns, AreTheSegmentsOfConstantSpeed) {
  std::vector<double> time, dq;
  for (int k = 0; k < 1000; ++k) {
    time.push_back(0.01 * k);
    dq.push_back(k < 200 ? 0.0 : k < 500 ? 0.2 : k < 530 ? -0.1 : k < 800 ? 0.2 * std::sin(0.1 * k) : -0.4);
  }
  const std::vector<SteadyRun> runs = steady_runs(time, dq);
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].from, 200u);
  EXPECT_EQ(runs[0].end, 500u);
  EXPECT_NEAR(runs[1].velocity, -0.4, 1e-12);
}

}  // namespace
}  // namespace veridyn
