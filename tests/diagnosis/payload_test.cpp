#include "support/simulated.hpp"
#include "veridyn/identification/rest_poses.hpp"
#include "veridyn/diagnosis/payload.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cli/tool.hpp"
#include "diagnosis/search/row_constants.hpp"
#include "simulation/simulation_support.hpp"
#include "files/output_file.hpp"
#include "support/random.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/effects/effect_facts.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/simulation/plausible_model.hpp"

// A point mass on a simulated arm whose own values are known exactly.

namespace veridyn {
namespace {

// With a single wave a spring, gravity and inertia would be collinear.
MotionSamples two_waves(int joints) {
  MotionSamples m = waves(joints, 0.4);
  for (int i = 0; i < joints; ++i) {
    const double w = 5.1 + 0.4 * i;
    const Eigen::ArrayXd angle = w * m.time.array();
    m.q.col(i).array() += 0.1 * angle.sin();
    m.dq.col(i).array() += 0.1 * w * angle.cos();
    m.ddq.col(i).array() -= 0.1 * w * w * angle.sin();
  }
  return m;
}

// The arm with a point mass on a frame.
Model with_point(const Model& arm, const std::string& on, double mass, const Eigen::Vector3d& com) {
  ModelDescription d = arm.description();
  Frame load;
  load.name = "point";
  load.parent = arm.find_frame(on);
  load.variable.coefficients = VectorXd::Zero(arm.joints());
  load.body = Body{};
  load.body->phi = inertial_parameters(mass, com, Eigen::Matrix<double, 6, 1>::Zero());
  d.frames.push_back(std::move(load));
  return Model(std::move(d));
}

// The torques of effects at rest, as offsets of the joints.
double held_torque(const Model& arm, int joint, const VectorXd& q) {
  double sum = 0.0;
  for (const EffectTerm& term : arm.effects()) {
    const EffectFacts effect(arm, term);
    if (effect.traits().dry != DryFriction::kNone || effect.traits().memory) continue;
    AxisSample x;
    x.s = term.axis.coefficients.dot(q) + term.axis.offset;
    sum += term.axis.coefficients[joint] * effect.force_at(x);
  }
  return sum;
}

class Payload : public testing::Test {
 protected:
  Payload() : arm_(plausible_model(read_model("elbow-6r"), 4).arm) {}

  std::string recording_with(const std::string& hidden, unsigned seed) const {
    return recording_with(hidden, seed, waves(arm_.joints(), 0.6));
  }

  std::string recording_with(const std::string& hidden, unsigned seed,
                             const MotionSamples& motion) const {
    SimulationOptions options;
    if (!hidden.empty()) options.hidden.push_back(parse_hidden_effect(hidden));
    options.noise = sensor_noise("dvrk");
    options.seed = seed;
    const SimulatedRecording s = simulate_recording(arm_, motion, options);
    const std::string path = folder_.path("load" + std::to_string(seed) + ".csv");
    write_recording(recording_of(s), path);
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
  // The error with changed friction and offsets alone is reported apart from that with the load.
  EXPECT_LT(report.error_with_drift.norm(), report.error_before.norm());
  EXPECT_LT(report.error_after.norm(), 0.5 * report.error_with_drift.norm());
  for (Eigen::Index i = 0; i < report.error_before.size(); ++i)
    EXPECT_LE(report.error_after[i], report.error_before[i] + 0.01);
}

TEST_F(Payload, AVelocityInDegreesIsNoLoad) {
  const std::string last = arm_.frames().back().name;
  Recording r = read_recording(recording_with("payload:" + last + ":mass=1.5,x=0.05,y=-0.02,z=0.08", 2));
  r.dq.col(0) *= 180.0 / M_PI;
  const std::string path = folder_.path("degrees.csv");
  write_recording(r, path);
  const PayloadReport found = find_payload(arm_, {path}, {}, last);
  ASSERT_EQ(found.links.size(), 1U) << found.reason;
  EXPECT_NEAR(found.links[0].mass, 1.5, 0.075);
}

// The torque of the fifth joint was not recorded.
TEST_F(Payload, AJointWithoutTorqueDoesNotChangeTheLoad) {
  const std::string last = arm_.frames().back().name;
  MotionSamples motion{VectorXd::LinSpaced(3000, 0.0, 29.99), MatrixXd(3000, 6), {}, {}};
  for (int i = 0; i < 6; ++i)
    motion.q.col(i) = 0.5 * ((0.9 + 0.17 * i) * motion.time.array() + i).sin() + 0.2 * ((2.3 + 0.31 * i) * motion.time.array() + 2 * i).sin();
  Recording r = read_recording(recording_with("payload:" + last + ":mass=1.5,x=0.05,y=-0.02,z=0.08", 1, with_derivatives(motion)));
  r.tau.col(4).setZero();
  const std::string path = folder_.path("silent.csv");
  write_recording(r, path);
  const PayloadReport report = find_payload(arm_, {path});
  ASSERT_TRUE(report.found()) << report.report();
  const PayloadEstimate& load = report.links.front();
  EXPECT_EQ(load.frame, last) << report.report();
  EXPECT_NEAR(load.mass, 1.5, 0.05) << report.report();
  EXPECT_LT((load.com - Eigen::Vector3d(0.05, -0.02, 0.08)).norm(), 0.02) << report.report();
}

// A load on the axis of the last joint has the same torques on the link before it, at whose frame it then sits.
TEST_F(Payload, OfEquivalentLinksTheOneNearestToTheLoadIsNamed) {
  arm_ = plausible_model(read_model("planar-2r"), 4).arm;
  const Frame& last = arm_.frames().back();
  int other_gains_more = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const std::string path =
        recording_with("payload:" + last.name + ":mass=5,x=-0.4", seed, two_waves(arm_.joints()));
    const PayloadReport found = find_payload(arm_, {path});
    ASSERT_GE(found.links.size(), 2U) << found.reason;
    EXPECT_NE(found.links[0].frame, last.name) << seed;
    EXPECT_EQ(found.links[1].frame, last.name) << seed;
    EXPECT_LT(found.links[0].com.norm(), 0.5 * found.links[1].com.norm()) << seed;
    EXPECT_GT(found.links[1].gain, 0.95 * found.links[0].gain) << seed;
    other_gains_more += found.links[1].gain > found.links[0].gain ? 1 : 0;
  }
  EXPECT_GT(other_gains_more, 0);  // else nothing is tested here
}

// The axes of a SCARA are all vertical: torques do not depend on the height of a load.
TEST_F(Payload, AnUndeterminedHeightHasTheIntervalOfTheReach) {
  arm_ = plausible_model(read_model("scara"), 4).arm;
  const std::string frame = arm_.frames().back().name;
  const std::string path =
      recording_with("payload:" + frame + ":mass=0.8,x=0.02,y=0.01,z=0.05", 3, two_waves(arm_.joints()));
  const PayloadReport found = find_payload(arm_, {path}, {}, frame);
  ASSERT_EQ(found.links.size(), 1U) << found.reason;
  const PayloadEstimate& load = found.links[0];
  EXPECT_TRUE(load.seen[0] && load.seen[1]);
  EXPECT_FALSE(load.seen[2]);
  EXPECT_GT(load.com_half_width[2], 0.1);
  EXPECT_LT(load.com_half_width[0], 0.1);
  EXPECT_NEAR(load.com[0], 0.02, 0.02);
}

// The axis of the elbow leans a little, so that torques depend on the height far below the noise. (With a leaning base they do
// not depend on it: all axes lean alike.)
TEST_F(Payload, AHeightBelowTheNoiseIsZero) {
  const Model upright = plausible_model(read_model("scara"), 4).arm;
  for (const double lean : {1e-6, 1e-5, 1e-4}) {
    const FrameConstant alpha{*upright.find_frame("inner"), FrameNumber::kAlpha, {}};
    arm_ = with_constant(upright, alpha, value_in(upright, alpha) + lean);
    const std::string frame = arm_.frames().back().name;
    for (const unsigned seed : {3U, 4U, 5U}) {
      const std::string path =
          recording_with("payload:" + frame + ":mass=0.8,x=0.02,y=0.01,z=0.05", seed, two_waves(arm_.joints()));
      const PayloadReport found = find_payload(arm_, {path}, {}, frame);
      ASSERT_EQ(found.links.size(), 1U) << found.reason;
      EXPECT_FALSE(found.links[0].seen[2]);
      EXPECT_NE(found.links[0].com[2], 0.0);
      EXPECT_LT(std::abs(found.links[0].com[2]), 0.1) << seed << ", " << lean;
    }
  }
}

TEST_F(Payload, ALoadTakenOffIsNegative) {
  const std::string last = arm_.frames().back().name;
  const Model bare = arm_;
  const std::string path = recording_with("", 6, two_waves(arm_.joints()));
  ModelDescription d = bare.description();
  Frame tool;
  tool.name = "screwdriver";
  tool.parent = bare.find_frame(last);
  tool.variable.coefficients = VectorXd::Zero(bare.joints());
  tool.body = Body{};
  tool.body->phi = inertial_parameters(0.5, {0.0, 0.0, 0.05}, Eigen::Matrix<double, 6, 1>::Zero());
  d.frames.push_back(tool);
  const PayloadReport report = find_payload(Model(d), {path});
  ASSERT_TRUE(report.found()) << report.report();
  EXPECT_NEAR(report.links[0].mass, -0.5, 0.05) << report.report();
  EXPECT_LE(report.links[0].mass_low, -0.5);
  EXPECT_GE(report.links[0].mass_high, -0.5);
  EXPECT_LT((report.links[0].com - Eigen::Vector3d(0.0, 0.0, 0.05)).norm(), 0.02) << report.report();
}

TEST_F(Payload, ASpringIsNoLoadAndItsJointStaysUnexplained) {
  arm_ = plausible_model(read_model("planar-2r"), 4).arm;
  const PayloadReport report = find_payload(arm_, {recording_with("joint_spring:1:stiffness=60", 7, two_waves(arm_.joints()))});
  EXPECT_FALSE(report.found()) << report.report();
}

// Dry friction of unknown direction widens the interval.
TEST_F(Payload, PosesAtRestDetermineALoadWithinTheirFriction) {
  const std::string last = arm_.frames().back().name;
  const Model loaded = with_point(arm_, last, 1.5, {0.05, -0.02, 0.08});
  const VectorXd friction = dry_friction(arm_);
  Recording poses;
  poses.source = "poses";
  poses.poses = true;
  poses.time = VectorXd::LinSpaced(24, 0.0, 23.0);
  Random random(4);
  poses.q = MatrixXd(24, 6);
  poses.tau = poses.dq = MatrixXd::Zero(24, 6);
  RigidBodyDynamics dynamics(loaded, *loaded.inertial_values());
  for (Eigen::Index k = 0; k < 24; ++k) {
    const VectorXd q = random.vector(6, -1.5, 1.5), still = VectorXd::Zero(6);
    VectorXd tau(6);
    dynamics.inverse_dynamics(q, still, still, tau);
    poses.q.row(k) = q.transpose();
    for (int i = 0; i < 6; ++i) poses.tau(k, i) = tau[i] + held_torque(arm_, i, q) + friction[i] * random.vector(1, -1.0, 1.0)[0];
  }
  const PayloadReport report = find_payload(arm_, {poses}, {}, last);
  ASSERT_EQ(report.links.size(), 1U) << report.reason;
  const PayloadEstimate& load = report.links[0];
  EXPECT_LE(load.mass_low, 1.5) << report.report();
  EXPECT_GE(load.mass_high, 1.5) << report.report();
  EXPECT_NE(report.report().find("Dry friction holds a resting joint"), std::string::npos) << report.report();
  ModelDescription d = arm_.description();
  d.effects.clear();
  poses.dq.setZero();
  const Model frictionless(d);
  Recording clean = poses;
  for (Eigen::Index k = 0; k < 24; ++k) {
    VectorXd tau(6);
    dynamics.inverse_dynamics(poses.q.row(k).transpose(), VectorXd(VectorXd::Zero(6)), VectorXd(VectorXd::Zero(6)), tau);
    clean.tau.row(k) = tau.transpose();
  }
  const PayloadReport sure = find_payload(frictionless, {clean}, {}, last);
  ASSERT_TRUE(sure.found()) << sure.report();
  EXPECT_NEAR(sure.links[0].mass, 1.5, 0.01) << sure.report();
  EXPECT_LT(sure.links[0].mass_high - sure.links[0].mass_low, load.mass_high - load.mass_low);
}

TEST_F(Payload, OnlyTheGivenLinkIsTested) {
  const std::string last = arm_.frames().back().name;
  const std::string path = recording_with("payload:" + last + ":mass=1", 2);
  const PayloadReport report = find_payload(arm_, {path}, {}, last);
  ASSERT_EQ(report.links.size(), 1U);
  EXPECT_EQ(report.links[0].frame, last);
  EXPECT_THROW(find_payload(arm_, {path}, {}, "no_such_frame"), InvalidInput);
}

TEST_F(Payload, FrictionThatACadModelDoesNotHaveIsFittedFirst) {
  ModelDescription d = arm_.description();
  for (EffectTerm& term : d.effects) {
    for (const EffectParameter& p : find_effect(term.effect).parameters()) term.values.erase(p.name);
  }
  const Model cad{std::move(d)};
  ASSERT_FALSE(has_all_values(cad));
  const std::string tool = cad.frames().back().name;
  const PayloadReport report = find_payload(cad, {recording_with("payload:" + tool + ":mass=0.6", 5, two_waves(arm_.joints()))});
  ASSERT_FALSE(report.links.empty());
  EXPECT_TRUE(report.found()) << report.report();
  EXPECT_NEAR(report.links.front().mass, 0.6, 0.1) << report.report();
  EXPECT_LT(report.error_after.norm(), 0.7 * report.error_before.norm()) << report.report();
}

// The arm as identified, with this training error of every joint.
Model with_training_error(const Model& arm, const VectorXd& error) {
  ModelDescription d = arm.description();
  d.identified = IdentifiedBase{};
  d.identified->error = error;
  return Model(std::move(d));
}

MotionSamples long_motion(int joints, Eigen::Index rows) {
  MotionSamples motion{VectorXd::LinSpaced(rows, 0.0, 0.01 * static_cast<double>(rows - 1)), MatrixXd(rows, joints), {}, {}};
  for (int i = 0; i < joints; ++i)
    motion.q.col(i) = 0.5 * ((0.9 + 0.17 * i) * motion.time.array() + i).sin() + 0.2 * ((2.3 + 0.31 * i) * motion.time.array() + 2 * i).sin();
  return with_derivatives(motion);
}

// The model is not better than the difference: only the factor tells it.
TEST_F(Payload, OneFactorOfAllTorquesIsNoLoad) {
  const std::string last = arm_.frames().back().name;
  const MotionSamples motion = long_motion(6, 3000);
  for (const bool loaded : {true, false}) {
    Recording r = read_recording(recording_with(loaded ? "payload:" + last + ":mass=1.5,x=0.05,y=-0.02,z=0.08" : "", 1, motion));
    if (!loaded) r.tau *= 1.1;
    const std::string path = folder_.path("gain.csv");
    write_recording(r, path);
    const PayloadReport report = find_payload(with_training_error(arm_, VectorXd::Constant(6, 0.1)), {path});
    EXPECT_EQ(report.found(), loaded) << report.report();
    EXPECT_EQ(report.torque_factor != 0.0, !loaded) << report.report();
    if (loaded) continue;
    EXPECT_NEAR(report.torque_factor, 1.1, 0.01);
    EXPECT_NE(report.headline().find("torques that are 1.1 times the model's on every joint explain as much"), std::string::npos) << report.headline();
  }
}

// Twenty times what the model leaves of its own recordings.
TEST_F(Payload, WhatIsFarAboveTheModelsOwnErrorIsNotExplainedHoweverSmall) {
  const std::string last = arm_.frames().back().name, path = recording_with("payload:" + last + ":mass=1.5,x=0.05,y=-0.02,z=0.08", 1, long_motion(6, 3000));
  const PayloadReport good = find_payload(arm_, {path}, {}, last);
  EXPECT_TRUE(find_payload(with_training_error(arm_, good.error_after), {path}, {}, last).found());
  EXPECT_LT(good.error_after.minCoeff(), 0.05);
  const PayloadReport report = find_payload(with_training_error(arm_, 0.05 * good.error_after), {path}, {}, last);
  EXPECT_EQ(report.links.front().unexplained.size(), 6U) << report.report();
}

TEST_F(Payload, OnAGivenLinkTheJointsBeyondItThatStayUnexplainedAreNamed) {
  const std::string last = arm_.frames().back().name;
  const MotionSamples motion = long_motion(6, 3000);
  const std::string path = recording_with("payload:" + last + ":mass=1.5,x=0.05,y=-0.02,z=0.08", 1, motion);
  const Model model = with_training_error(arm_, VectorXd::Constant(6, 0.01));
  const auto says = [&](const std::string& link) {
    return find_payload(model, {path}, {}, link).report().find("acts on joints whose torque the model does not explain") != std::string::npos;
  };
  int elbow = 0;
  while (!(arm_.moves({elbow}, {1}) && !arm_.moves({elbow}, {2}))) ++elbow;  // a frame that the third joint does not move
  EXPECT_TRUE(says(arm_.frames()[elbow].name));
  EXPECT_FALSE(says(last));
}

// The first axis is vertical: gravity alone has no torque about it.
TEST_F(Payload, FewPosesHoldNothingOutAndAJointWithoutTorqueHasNoError) {
  const std::string last = arm_.frames().back().name;
  ModelDescription d = arm_.description();
  d.effects.clear();
  const Model bare(d), loaded = with_point(bare, last, 1.5, {0.05, -0.02, 0.08});
  RigidBodyDynamics dynamics(loaded, *loaded.inertial_values());
  for (const Eigen::Index count : {5, 8}) {
    Random random(4);
    Recording poses;
    poses.source = "poses";
    poses.poses = true;
    poses.time = VectorXd::LinSpaced(count, 0.0, static_cast<double>(count - 1));
    poses.q = MatrixXd(count, 6);
    poses.tau = poses.dq = MatrixXd::Zero(count, 6);
    for (Eigen::Index k = 0; k < count; ++k) {
      const VectorXd q = random.vector(6, -1.5, 1.5), still = VectorXd::Zero(6);
      VectorXd tau(6);
      dynamics.inverse_dynamics(q, still, still, tau);
      poses.q.row(k) = q.transpose();
      poses.tau.row(k) = tau.transpose();
    }
    const PayloadReport report = find_payload(bare, {poses});
    ASSERT_FALSE(report.links.empty());
    EXPECT_TRUE(std::isnan(report.error_before[0])) << report.report();
    EXPECT_TRUE(report.error_before.tail(5).allFinite()) << report.report();
    EXPECT_EQ(std::isnan(report.links.front().gain), count == 5) << report.report();
    EXPECT_EQ(report.report().find("that takes 8 poses, twice as many as a load has numbers (mass and centre), and these are 5") != std::string::npos, count == 5) << report.report();
    EXPECT_EQ(report.report().find("in the order of held out") == std::string::npos, count == 5) << report.report();
  }
}

TEST_F(Payload, AnArmWithoutValuesIsRefused) {
  EXPECT_THROW(find_payload(read_model("psm-3dof"), {"none.csv"}), InvalidInput);
}

// A mass whose interval contains zero is not determined, and has no centre.
TEST(PayloadTable, ShowsTheGainAndNoCentreOfAnUndeterminedMass) {
  PayloadReport report;
  report.robot = "arm";
  PayloadEstimate sure;
  sure.frame = "tool";
  sure.mass = 0.5;
  sure.mass_low = 0.4;
  sure.mass_high = 0.6;
  sure.com = Eigen::Vector3d(0.01, 0.02, 0.03);
  sure.gain = 1.5;
  PayloadEstimate vague = sure;
  vague.frame = "upper";
  vague.mass = 1.6e-4;
  vague.mass_low = 0.0;
  vague.mass_high = 541.4;
  vague.com = Eigen::Vector3d(8.36, 0.0, 0.0);
  vague.explained = -1e-9;
  vague.gain = 0.25;
  report.links = {sure, vague};
  report.error_before = report.error_with_drift = report.error_after = VectorXd::Zero(1);
  const std::string text = report.report();
  for (const char* part : {"held out", "1.500", "0.250", "not determined", "0.030"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
  for (const char* part : {"8.36", "541", "-0.0"})
    EXPECT_EQ(text.find(part), std::string::npos) << part << "\n" << text;
}

// A load is found if the interval of its mass or moment excludes zero, its gain is large enough and its mass is possible.
TEST(PayloadTable, ReportsWhetherALoadIsFound) {
  PayloadReport report;
  report.robot = "arm";
  report.reason = "nothing moves";
  EXPECT_FALSE(report.found());
  EXPECT_EQ(report.report(), "arm: no payload: nothing moves\n");
  PayloadEstimate load;
  load.frame = "tool";
  load.others = {"flange"};
  load.mass = 0.5;
  load.mass_low = 0.4;
  load.mass_high = 0.6;
  load.moment_half_width.setOnes();
  load.gain = 0.5;
  report.smallest_gain = 0.1;
  report.links = {load};
  EXPECT_TRUE(report.found());
  EXPECT_EQ(report.report().find("arm: a load of 0.5 kg on tool (95 %: 0.4 to 0.6 kg)\n"), 0U) << report.report();
  EXPECT_NE(report.report().find("or on flange: it moves so alike"), std::string::npos);
  // A load taken off.
  report.links[0].mass = -0.5;
  report.links[0].mass_low = -0.6;
  report.links[0].mass_high = -0.4;
  EXPECT_TRUE(report.found());
  EXPECT_EQ(report.report().find("arm: a load of -0.5 kg on tool (95 %: -0.6 to -0.4 kg)\n"), 0U) << report.report();
  report.links[0].mass = 0.5;
  report.links[0].mass_high = 0.6;
  report.links[0].mass_low = 0.4;
  // A joint that it acts on and does not explain.
  report.links[0].unexplained = {"lift"};
  EXPECT_FALSE(report.found());
  EXPECT_NE(report.report().find("on tool, lift is not explained"), std::string::npos) << report.report();
  report.links[0].unexplained.clear();
  report.links[0].mass_low = 0.0;
  EXPECT_FALSE(report.found());
  EXPECT_EQ(report.report().find("arm: no load that these recordings could be sure of\n"), 0U) << report.report();
  report.links[0].moment.x() = -1.1;
  EXPECT_TRUE(report.found());
  EXPECT_EQ(report.report().find("arm: a load with a moment of 1.1 kg m on tool, whose mass these recordings do not tell\n"), 0U) << report.report();
  report.links[0].gain = 0.05;
  EXPECT_FALSE(report.found());
  report.links[0].gain = 0.5;
  report.links[0].mass = report.links[0].mass_high = 200.0;  // the search ends there
  EXPECT_FALSE(report.found());
  EXPECT_EQ(report.report().find("200"), std::string::npos) << report.report();
}

}  // namespace
}  // namespace veridyn
