#include "veridyn/model/joint_sensors.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/near.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/fixed_coordinates.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

// An arm whose second joint is wrong in every way that a MODEL can know.
Model wrong_arm() {
  ModelDescription d = read_model("psm-3dof").description();
  d.coordinates[1].recorded = {1.25, 0.004, 0.1};
  d.coordinates[1].drive_gain = 2.0;
  return Model(std::move(d));
}

TEST(JointSensors, RemovingAddedErrorsRestoresTheTrueValues) {
  const JointSensors sensors(wrong_arm());
  const VectorXd true_q = Eigen::Vector3d(0.3, -0.2, 0.1);
  const VectorXd true_tau = Eigen::Vector3d(1.0, 2.0, -3.0);
  VectorXd q = true_q;
  VectorXd tau = true_tau;
  sensors.add_position_errors(q);
  sensors.add_torque_errors(tau);
  EXPECT_TRUE(near(q, Eigen::Vector3d(0.3, -0.1, 0.1), 1e-15));   // measured = true + offset
  EXPECT_TRUE(near(tau, Eigen::Vector3d(1.0, 2.5, -3.0), 1e-15));  // measured = gain * true
  sensors.correct_positions(q);
  sensors.correct_torques(tau);
  EXPECT_TRUE(near(q, true_q, 1e-15));
  EXPECT_TRUE(near(tau, true_tau, 1e-15));
  EXPECT_FALSE(sensors.ideal());
}

// Current times drive gain is the recorded torque; the gain is taken off that.
TEST(JointSensors, CurrentsBecomeTrueTorques) {
  const JointSensors sensors(wrong_arm());
  VectorXd current = Eigen::Vector3d(0.0, 5.0, 0.0);
  sensors.correct_currents(current);
  EXPECT_DOUBLE_EQ(current[1], 5.0 * 2.0 / 1.25);
}

TEST(JointSensors, AModelWithoutErrorsChangesNoValue) {
  const JointSensors sensors(read_model("psm-3dof"));
  const VectorXd before = Eigen::Vector3d(0.1, 1.0 / 3.0, -7e-12);
  VectorXd v = before;
  sensors.correct_positions(v);
  sensors.add_position_errors(v);
  sensors.correct_torques(v);
  sensors.add_torque_errors(v);
  EXPECT_TRUE(sensors.ideal());
  EXPECT_EQ(v, before);
  EXPECT_TRUE(sensors.descriptions(read_model("psm-3dof")).empty());
}

// A strong joint in the channel of a weak one: no command exceeds its drive for any signs, and one reaches it.
TEST(JointSensors, TorqueLimitsHoldUnderCrosstalkForEverySign) {
  std::vector<RecordedChannel> channels(3);
  channels[0].torque_gain = 1.25;
  channels[1].torque_crosstalk = {{{0}, -0.15}};
  const JointSensors sensors(channels);
  const Eigen::Vector3d largest(10.0, 1.0, 3.0);
  const VectorXd most = sensors.largest_true_torques(largest);
  EXPECT_GT(most.minCoeff(), 0.0);
  EXPECT_EQ(most[2], 3.0);
  double reached = 0.0;
  for (int signs = 0; signs < 8; ++signs) {
    VectorXd tau = most;
    for (int i = 0; i < 3; ++i) tau[i] *= (signs >> i & 1) == 0 ? 1.0 : -1.0;
    sensors.add_torque_errors(tau);
    EXPECT_TRUE((tau.cwiseAbs().array() <= largest.array() * (1.0 + 1e-12)).all()) << tau.transpose();
    reached = std::max(reached, std::abs(tau[1]));
  }
  EXPECT_NEAR(reached, 1.0, 1e-12);
  channels[1].torque_crosstalk.clear();
  EXPECT_EQ(JointSensors(channels).largest_true_torques(largest), Eigen::Vector3d(8.0, 1.0, 3.0));
}

// Gain, then crosstalk, then delay are taken off in this order, and put on in the other.
TEST(JointSensors, CrosstalkAndGainAreInvertible) {
  ModelDescription d = wrong_arm().description();
  d.coordinates[1].recorded.torque_crosstalk = {{{0}, 0.5}, {{2}, -0.1}};
  d.coordinates[2].recorded.torque_crosstalk = {{{1}, 0.2}};
  const Model arm(std::move(d));
  const JointSensors sensors(read_yaml(to_yaml(arm), "again"));
  const VectorXd true_tau = Eigen::Vector3d(1.0, 2.0, -3.0);
  VectorXd tau = true_tau;
  sensors.add_torque_errors(tau);
  EXPECT_TRUE(near(tau, Eigen::Vector3d(1.0, 1.25 * (2.0 + 0.5 + 0.3), -3.0 + 0.4), 1e-14));
  sensors.correct_torques(tau);
  EXPECT_TRUE(near(tau, true_tau, 1e-14));
  VectorXd current = Eigen::Vector3d(0.0, 1.25 * 2.8 / 2.0, 0.0);  // [A] without drive gains of the others
  sensors.correct_currents(current);
  EXPECT_NEAR(current[1], 2.8 / (1.0 + 0.1 * 0.2), 1e-14);
  VectorXd time = VectorXd::LinSpaced(3, 0.0, 1.0);
  MatrixXd q = MatrixXd::Zero(3, 3), all = true_tau.transpose().replicate(3, 1);
  sensors.add_errors(time, q, all);
  EXPECT_NEAR(all(2, 1), 3.5, 1e-14);
  EXPECT_FALSE(sensors.ideal());
  EXPECT_EQ(sensors.descriptions(arm).back(),
            "the recorded torque of joint 'insertion' is mixed with 0.2 times that of joint 'pitch'");
}

TEST(JointSensors, CrosstalkRefersToTheSameJointAfterAnotherIsFixed) {
  ModelDescription d = read_model("psm-3dof").description();
  d.coordinates[1].recorded.torque_crosstalk = {{{2}, -0.1}};
  const Model arm(std::move(d));
  const Model held = with_fixed(arm, {{"yaw", 0.3}});
  EXPECT_EQ(held.coordinates()[0].recorded.torque_crosstalk, (std::map<JointIndex, double>{{{1}, -0.1}}));
  EXPECT_THROW(with_fixed(arm, {{"insertion", 0.1}}), InvalidInput);
}

TEST(JointSensors, SingularCrosstalkIsRefused) {
  std::vector<RecordedChannel> both(2);
  both[0].torque_crosstalk = {{{1}, 2.0}};
  both[1].torque_crosstalk = {{{0}, 0.5}};
  EXPECT_THROW(JointSensors{both}, InvalidInput);
  both[1].torque_crosstalk = {{{1}, 0.5}};
  EXPECT_THROW(JointSensors{both}, InvalidInput);
}

// A ramp that is recorded late is exactly the ramp of earlier times, and comes back whole but for
// its last samples, whose record lies beyond the end.
TEST(JointSensors, ADelayIsAppliedAndCorrected) {
  const JointSensors sensors(wrong_arm());
  constexpr int kRows = 50;
  constexpr double kStep = 0.0015;  // [s]: the delay is no whole number of rows
  const VectorXd time = VectorXd::LinSpaced(kRows, 0.0, kStep * (kRows - 1));
  MatrixXd q = MatrixXd::Zero(kRows, 3);
  MatrixXd tau = time.replicate(1, 3);
  sensors.add_errors(time, q, tau);
  EXPECT_NEAR(tau(40, 1), 1.25 * (time[40] - 0.004), 1e-12);
  EXPECT_DOUBLE_EQ(tau(40, 0), time[40]);
  EXPECT_DOUBLE_EQ(q(7, 1), 0.1);
  const auto recorded = [&](Eigen::Index k) { return tau(k, 1); };
  for (int k = 1; k < kRows - 3; ++k)  // what is recorded of row 0 is what was before
    EXPECT_NEAR(sensors.torque_at({1}, k, kRows, kStep, recorded), 1.25 * time[k], 1e-12);
  EXPECT_DOUBLE_EQ(sensors.torque_at({1}, kRows - 1, kRows, kStep, recorded), tau(kRows - 1, 1));
}

TEST(JointSensors, EveryErrorIsDescribedInASentence) {
  const Model arm = wrong_arm();
  const std::vector<std::string> words = JointSensors(arm).descriptions(arm);
  ASSERT_EQ(words.size(), 3U);
  EXPECT_EQ(words[0], "the encoder of joint 'pitch' shows 0.1 rad more than there is");
  EXPECT_EQ(words[1], "the recorded torque of joint 'pitch' is 1.25 times the true one");
  EXPECT_EQ(words[2], "the recorded torque of joint 'pitch' is 4 ms late");
}

TEST(JointSensors, InvalidGainsAreRefused) {
  EXPECT_THROW(JointSensors({{0.0, 0.0, 0.0}}), InvalidInput);
  EXPECT_THROW(JointSensors({{1.0, 0.0, std::nan("")}}), InvalidInput);
}

}  // namespace
}  // namespace veridyn
