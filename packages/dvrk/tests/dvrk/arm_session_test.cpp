#include "dvrk/run/arm_session.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "dvrk/arm_bench.hpp"
#include "support/near.hpp"
#include "support/random.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

const char* const kNeedleDriver = "large-needle-driver-400006";
struct ArmCase {
  std::string arm;
  std::string instrument;
};

class OnEveryHomedArm : public testing::TestWithParam<ArmCase> {};

// From pots to encoders to joints: the arm's position is known to a bit of the pots and a count.
TEST_P(OnEveryHomedArm, HomingFindsTheActualJointPositions) {
  const ArmFacts facts = read_arm(GetParam().arm);
  const RobotConfig robot = nominal_config(facts).robots.at(0);
  const MatrixXd K = facts.coupling(GetParam().instrument);
  VectorXd start(robot.size());
  for (int i = 0; i < robot.size(); ++i) {
    const ActuatorConfig& a = robot.actuators[i];
    start[i] = a.lower + (0.4 + 0.02 * i) * (a.upper - a.lower);  // the sixth stands at zero
  }
  Bench bench(robot, K, start);
  bench.idle(0.01);
  EXPECT_TRUE(bench.arm.needs_homing());
  EXPECT_NE(bench.arm.power_on(), nullptr);
  const HomingReport homing = bench.arm.home();
  ASSERT_TRUE(homing.done) << homing.reason;
  EXPECT_TRUE(homing.outside_limits.empty());
  EXPECT_FALSE(bench.arm.needs_homing());
  bench.idle(0.01);
  VectorXd grain(robot.size());
  for (int i = 0; i < robot.size(); ++i) {
    const ActuatorConfig& a = robot.actuators[i];
    grain[i] = std::abs(a.volts_to_position.scale * a.bits_to_volts.scale);
  }
  if (robot.pots_to_actuators.size() > 0) grain = robot.pots_to_actuators.cwiseAbs() * grain;
  for (int i = 0; i < robot.size(); ++i) {
    grain[i] += 2.0 * std::abs(robot.actuators[i].bits_to_position);
    EXPECT_NEAR(bench.arm.state().actuator_q[i], start[i], grain[i]) << i;
  }
  EXPECT_TRUE(near(bench.arm.state().q, K * bench.arm.state().actuator_q, 1e-12));
}

INSTANTIATE_TEST_SUITE_P(Arms, OnEveryHomedArm,
                         testing::Values(ArmCase{"PSM1", kNeedleDriver}, ArmCase{"PSM3", ""},
                                         ArmCase{"MTML", ""}, ArmCase{"MTMR", ""},
                                         ArmCase{"ECM", ""}),
                         [](const auto& c) { return c.param.arm; });

// Joint torques arrive at the motors through calibration and coupling: what the motors push with,
// carried to the joints by the power that it does, is what was commanded.
TEST(ArmSession, JointTorquesOfTheMotorsEqualTheCommandedOnes) {
  const MatrixXd K = read_arm("PSM1").coupling(kNeedleDriver);
  Bench bench(example(), K, example_start());
  bench.idle(0.01);
  ASSERT_TRUE(bench.arm.home().done);
  bench.idle(0.01);
  ASSERT_EQ(bench.arm.power_on(), nullptr);
  bench.idle(0.5);
  ASSERT_TRUE(bench.arm.ready()) << describe(bench.arm.boards().state())
                                 << bench.arm.boards().faults().report();
  VectorXd tau(7);
  tau << 0.3, -0.2, 1.5, 0.02, 0.03, -0.02, 0.01;
  bench.run(0.01, [&] { bench.arm.set_torques(tau); });
  const VectorXd at_joints = K.inverse().transpose() * bench.load.effort;
  for (int i = 0; i < 7; ++i) EXPECT_NEAR(at_joints[i], tau[i], 5e-3 * std::abs(tau[i]) + 2e-4);
  // Measured currents convert back to the same torques. The example's feedback is calibrated apart from its
  // command, by some milliamperes.
  for (int i = 0; i < 7; ++i) EXPECT_NEAR(bench.arm.state().tau[i], tau[i], 0.05 * 1.5);
  // A cycle without a command is a cycle without current.
  bench.idle(2 * kCycle);
  for (int i = 0; i < 7; ++i) EXPECT_NEAR(bench.load.current[i], 0.0, 0.5 / 5242.0 + 1e-6) << i;
}

// A controller of the joints, blind to boards: proportional and derivative action moves every joint
// to its place and holds it there, directions and couplings included.
TEST(ArmSession, AJointPdControllerReachesItsGoal) {
  const MatrixXd K = read_arm("PSM1").coupling(kNeedleDriver);
  Bench bench(example(), K, example_start());
  bench.idle(0.01);
  ASSERT_TRUE(bench.arm.home().done);
  bench.idle(0.01);
  ASSERT_EQ(bench.arm.power_on(), nullptr);
  bench.idle(0.5);
  ASSERT_TRUE(bench.arm.ready());
  const VectorXd goal = K * example_start() + VectorXd::Constant(7, 0.03);
  VectorXd tau(7);
  bench.run(3.0, [&] {
    const BoardArmState& s = bench.arm.state();
    tau.noalias() = 1.0 * (goal - s.q) - 0.15 * s.dq;
    bench.arm.set_torques(tau);
  });
  EXPECT_TRUE(bench.arm.ready()) << bench.arm.boards().faults().report();
  EXPECT_TRUE(near(bench.arm.state().q, goal, 3e-3));
  EXPECT_TRUE(near(K * bench.load.q, bench.arm.state().q, 3e-3));
  bench.arm.power_off();
  bench.idle(0.05);
  EXPECT_FALSE(bench.arm.ready());
  EXPECT_EQ(bench.load.current.norm(), 0.0);
}

TEST(ArmSession, WithoutPowerTorqueCommandsCauseNoCurrent) {
  Bench bench(example(), MatrixXd(), example_start());
  bench.idle(0.01);
  ASSERT_TRUE(bench.arm.home().done);
  const VectorXd tau = VectorXd::Constant(7, 0.1);
  bench.run(0.05, [&] { bench.arm.set_torques(tau); });
  EXPECT_EQ(bench.load.current.norm(), 0.0);
}

// Bad torques end as zero current, not as the last command.
TEST(ArmSession, NonFiniteTorquesStopTheCurrent) {
  Bench bench(example(), MatrixXd(), example_start());
  bench.idle(0.01);
  ASSERT_TRUE(bench.arm.home().done);
  bench.idle(0.01);
  ASSERT_EQ(bench.arm.power_on(), nullptr);
  bench.idle(0.5);
  VectorXd tau = VectorXd::Constant(7, 0.02);
  bench.run(0.01, [&] { bench.arm.set_torques(tau); });
  EXPECT_GT(bench.load.current.cwiseAbs().minCoeff(), 1e-4);
  tau[3] = std::nan("");
  bench.run(3 * kCycle, [&] {
    bench.arm.set_torques(tau);
    EXPECT_FALSE(bench.arm.command().valid);
  });
  EXPECT_LT(bench.load.current.cwiseAbs().maxCoeff(), 0.6 / 5242.0);
}

// The endoscope's brakes: a push for two seconds, then less, and no torque before they are open.
TEST(ArmSession, BrakesOpenBeforeTheArmMoves) {
  const ArmFacts facts = read_arm("ECM");
  const RobotConfig robot = nominal_config(facts).robots.at(0);
  VectorXd start(4);
  start << 0.1, 0.1, 0.1, 0.1;
  Bench bench(robot, MatrixXd(), start);
  bench.load.inertia = 5.0;
  bench.load.damping = 20.0;  // creeps
  bench.idle(0.01);
  ASSERT_TRUE(bench.arm.home().done);
  bench.idle(0.01);
  ASSERT_EQ(bench.arm.power_on(), nullptr);
  const VectorXd tau = VectorXd::Constant(4, 0.5);
  bench.run(1.0, [&] { bench.arm.set_torques(tau); });
  EXPECT_EQ(bench.arm.boards().state(), PowerState::kOn);
  EXPECT_FALSE(bench.arm.ready());
  EXPECT_NEAR(bench.load.brake_bits[0], 0.25 * 5242.88, 1.0);
  EXPECT_LT(bench.load.current.cwiseAbs().maxCoeff(), 0.6 / 5242.0);
  bench.run(2.0, [&] { bench.arm.set_torques(tau); });
  EXPECT_TRUE(bench.arm.ready());
  EXPECT_NEAR(bench.load.brake_bits[0], 0.08 * 5242.88, 1.0);
  EXPECT_GT(bench.load.current.cwiseAbs().minCoeff(), 1e-4);
  bench.arm.power_off();
  bench.idle(0.02);
  EXPECT_EQ(bench.load.brake_bits[0], 0.0);
}

TEST(BrakeDriver, CurrentIsReducedAfterTheReleaseTime) {
  BrakeConfig config;
  config.release_current = 0.9;
  config.release_time = 2.0;
  config.released_current = 0.2;
  config.engaged_current = -0.1;
  BrakeDriver brake(config);
  using Wish = BrakeDriver::Wish;
  EXPECT_EQ(brake.current(Wish::kEngaged, 10.0), -0.1);
  EXPECT_EQ(brake.current(Wish::kReleased, 11.0), 0.9);
  EXPECT_EQ(brake.current(Wish::kReleased, 12.999), 0.9);
  EXPECT_FALSE(brake.released());
  EXPECT_EQ(brake.current(Wish::kReleased, 13.0), 0.2);
  EXPECT_TRUE(brake.released());
  EXPECT_EQ(brake.current(Wish::kEngaged, 14.0), -0.1);
  EXPECT_FALSE(brake.released());
  EXPECT_EQ(brake.current(Wish::kReleased, 15.0), 0.9);  // a push again
}

TEST(ArmSession, HomingRefusesImplausiblePots) {
  {
    Bench bench(example(), MatrixXd(), example_start());
    bench.load.shake = 0.05;  // the arm swings
    bench.idle(0.01);
    const HomingReport report = bench.arm.home();
    EXPECT_FALSE(report.done);
    EXPECT_NE(report.reason.find("moved by"), std::string::npos) << report.reason;
    EXPECT_NE(bench.arm.power_on(), nullptr);
  }
  {
    RobotConfig robot = example();
    robot.pot_lookup_table = "pots.json";
    Bench bench(robot, MatrixXd(), example_start());
    EXPECT_NE(bench.arm.home().reason.find("pots.json"), std::string::npos);
  }
  {
    VectorXd start = example_start();
    start[1] = 1.03;  // 59 degrees; 53 and 5 more are allowed
    Bench bench(example(), MatrixXd(), start);
    bench.idle(0.01);
    const HomingReport report = bench.arm.home();
    EXPECT_TRUE(report.done) << report.reason;
    EXPECT_EQ(report.outside_limits, std::vector<int>{1});
  }
  {
    Bench bench(example(), MatrixXd(), example_start());
    bench.idle(0.01);
    ASSERT_TRUE(bench.arm.home().done);
    bench.idle(0.01);
    ASSERT_EQ(bench.arm.power_on(), nullptr);
    bench.idle(0.5);
    EXPECT_EQ(bench.arm.home().reason, "power is on");
    // A refusal changes nothing: loaded encoders stay valid.
    bench.arm.power_off();
    bench.idle(0.05);
    EXPECT_EQ(bench.arm.power_on(), nullptr);
  }
}

TEST(ArmSession, StartHomesAnArmAfterPowerUp) {
  const RobotConfig robot = example();
  Inertias load(robot, example_start());
  BoardEmulator emulator(Bench::setups(robot), 3);
  emulator.attach(&load);
  EmulatedLink link(emulator);
  {
    ArmSession arm(link, robot);
    arm.start();
    EXPECT_TRUE(arm.preloaded());
    arm.update();
    EXPECT_TRUE(near(arm.state().q, example_start(), 5e-4));
  }
  // A later session finds the encoders loaded and does not change them.
  ArmSession later(link, robot);
  later.start();
  EXPECT_FALSE(later.preloaded());
  later.update();
  EXPECT_TRUE(near(later.state().q, example_start(), 5e-4));
  // An arm that swings is not started.
  emulator.board(0).reboot(0);
  load.shake = 0.05;
  ArmSession swinging(link, robot);
  EXPECT_THROW(swinging.start(), InvalidInput);
}

// Velocity words of firmware 6 have another form: differences of counts, or nothing.
TEST(ArmSession, OldFirmwareRequiresSoftwareVelocities) {
  RobotConfig robot = example();
  std::vector<BoardSetup> boards = Bench::setups(robot);
  for (BoardSetup& board : boards) board.firmware = 6;
  Inertias load(robot, example_start());
  BoardEmulator emulator(boards, 3);
  emulator.attach(&load);
  EmulatedLink link(emulator);
  EXPECT_THROW(ArmSession(link, robot).start(), InvalidInput);
  for (ActuatorConfig& a : robot.actuators) a.velocity_source = VelocitySource::kSoftware;
  ArmSession arm(link, robot);
  arm.start();
  arm.update();
  EXPECT_TRUE(near(arm.state().q, example_start(), 5e-4));
}

TEST(ArmSession, CurrentLimitsComeFromTheCalibration) {
  RobotConfig robot = example();
  robot.actuators[4].amps_to_bits = {-5242.88, 32850.0};
  robot.actuators[4].bits_to_amps = {-0.000190735, 6.26};
  const SessionOptions options = session_options(robot);
  EXPECT_EQ(options.bus.boards, (std::vector<int>{6, 7}));
  const ChannelSafety& safety = options.channels.at(1).at(0);
  EXPECT_TRUE(safety.used);
  EXPECT_EQ(safety.zero_command, 32850);
  EXPECT_NEAR(safety.zero_feedback, 6.26 / 0.000190735, 1e-9);
  EXPECT_NEAR(safety.max_current, 0.67 * 5242.88, 0.6);
  EXPECT_NEAR(safety.pot_tolerance, 5.0 * M_PI / 180.0, 1e-12);
  EXPECT_FALSE(options.channels.at(1).at(3).used);  // seven actuators on eight channels
  // A pot in the middle of its range, converted by the configuration and by the safety check.
  const ActuatorConfig& a = robot.actuators[4];
  EXPECT_NEAR(safety.pot_to_position(30000.0), a.volts_to_position(a.bits_to_volts(30000.0)),
              1e-12);
  // Pots on joints cannot be compared channel by channel.
  EXPECT_EQ(
      session_options(nominal_config(read_arm("MTML")).robots[0]).channels[0][0].pot_tolerance,
      0.0);
  robot.actuators[6].axis = 5;
  EXPECT_THROW(session_options(robot), InvalidInput);
}

// Two arms may have boards with the same ids; serial numbers in the configuration distinguish them.
TEST(ArmSessionBoards, WithOtherSerialNumbersThanConfiguredAreRefused) {
  for (const std::string& there : {std::string("1234-57"), std::string("9999-01"), std::string()}) {
    RobotConfig robot = example();
    const std::vector<int> ids = boards_of(robot);
    std::vector<BoardSetup> setups = Bench::setups(robot);
    setups[0].qla_serial = "QLA 1234-56";
    setups[1].qla_serial = there.empty() ? "" : "QLA " + there;
    BoardEmulator emulator(setups);
    Inertias load(robot, example_start());
    emulator.attach(&load);
    EmulatedLink link(emulator);
    ArmSession free(link, robot);
    EXPECT_NO_THROW(free.start());  // no serial numbers are configured
    robot.board_serials = {{ids[0], "1234-56"}, {ids[1], "1234-57"}};
    ArmSession own(link, robot);
    try {
      own.start();
      EXPECT_EQ(there, "1234-57");
    } catch (const InvalidInput& error) {
      EXPECT_NE(there, "1234-57");
      const std::string words = error.what();
      EXPECT_NE(words.find("expected 1234-57"), std::string::npos) << words;
      EXPECT_NE(words.find(there.empty() ? "without a serial number" : there), std::string::npos) << words;
    }
  }
}

TEST(ArmSessionBoards, SerialNumbersAreReadFromXmlAndJson) {
  IoConfig config = read_io_config(std::string(VERIDYN_SOURCE_DIR) +
                                   "/data/dvrk/sawRobotIO1394-PSM1-example.xml");
  config.robots[0].board_serials = {{6, "1234-56"}, {7, "1234-57"}};
  for (const std::string& content : {to_io_xml(config), to_io_json(config)}) {
    const std::string path = testing::TempDir() + "serials.io";
    const auto parsed = [&](const std::string& text) {
      std::ofstream(path) << text;
      return read_io_config(path);
    };
    const IoConfig again = parsed(content);
    ASSERT_EQ(again.robots[0].board_serials.size(), 2U);
    EXPECT_EQ(again.robots[0].board_serials[1].board, 7);
    EXPECT_EQ(again.robots[0].board_serials[1].serial, "1234-57");
    for (const char* bad : {"6", "6=", "=1", "16=1", "x=1"}) {
      std::string wrong = content;
      const auto at = wrong.find("6=1234-56");
      ASSERT_NE(at, std::string::npos);
      wrong.replace(at, 9, bad);
      EXPECT_THROW(parsed(wrong), InvalidInput) << bad;
    }
  }
}

}  // namespace
}  // namespace veridyn::dvrk
