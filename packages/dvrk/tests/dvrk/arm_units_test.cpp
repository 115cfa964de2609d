
#include "dvrk/arms/arm_units.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/near.hpp"
#include "support/random.hpp"
#include "dvrk/arms/arm_facts.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

const char* const kNeedleDriver = "large-needle-driver-400006";

RobotConfig example() {
  return read_io_config(std::string(VERIDYN_SOURCE_DIR) +
                        "/data/dvrk/sawRobotIO1394-PSM1-example.xml")
      .robots.at(0);
}

// Actuator 0 by hand, with the formulas of specification 12 and 15 written out.
TEST(ArmUnits, OneActuatorMatchesTheFormulasOfTheSpecification) {
  RobotConfig robot = example();
  robot.actuators[0].amps_to_bits = {-5242.88, 32851.0};
  robot.actuators[0].bits_to_amps = {-0.000190735, 6.2571};
  robot.actuators[0].volts_to_position = {-43.25 * M_PI / 180.0, 97.3125 * M_PI / 180.0};
  ArmUnits units(robot);
  std::vector<RawActuator> raw(7);
  raw[0].encoder = {0x800000 + 10000, 0x4000C000, 0x60003000, 0x60003000, 0x40000064};
  raw[0].pot = 32768;  // 2.25 V
  raw[0].current = 30000;
  BoardArmState state(7);
  units.read(raw.data(), state);
  EXPECT_NEAR(state.q[0], -10000 * 0.000442477876106 * M_PI / 180.0, 1e-13);
  EXPECT_NEAR(state.dq[0], -4000 * 0.000442477876106 * M_PI / 180.0, 1e-13);
  EXPECT_NEAR(state.pot_q[0], 0.0, 1e-12);  // 97.3125 deg - 43.25 deg/V * 2.25 V
  EXPECT_NEAR(state.current[0], 6.2571 - 30000 * 0.000190735, 1e-12);
  EXPECT_NEAR(state.tau[0], (6.2571 - 30000 * 0.000190735) / 0.4040893846, 1e-11);

  ArmCommand command(7);
  units.write(VectorXd::Unit(7, 0) * 0.5, command);
  EXPECT_EQ(command.bits[0], std::lround(32851 - 5242.88 * 0.5 * 0.4040893846));
}

struct CoupledArm {
  std::string arm;
  std::string instrument;
};

class OnEveryCoupling : public testing::TestWithParam<CoupledArm> {
 protected:
  ArmFacts facts = read_arm(GetParam().arm);
  MatrixXd K = facts.coupling(GetParam().instrument);
  RobotConfig robot = nominal_config(facts).robots.at(0);
  int n = robot.size();
};

// Power is the same in actuators and joints, whatever they do: dq . tau. Position and torque
// therefore go by one matrix and its inverse transposed.
TEST_P(OnEveryCoupling, PowerIsEqualInJointsAndActuators) {
  ArmUnits units(robot, K);
  Random random(5);
  std::vector<RawActuator> raw(n);
  BoardArmState state(n);
  for (int trial = 0; trial < 20; ++trial) {
    for (RawActuator& r : raw) {
      r.current = static_cast<std::uint16_t>(random.in(20000, 45000));
      r.encoder.period = 0x40000000 | static_cast<std::uint32_t>(random.in(20000, 90000));
      r.encoder.quarter1 = 0x60003000;
      r.encoder.quarter5 = 0x50003000;
    }
    units.read(raw.data(), state);
    const double power = state.dq.dot(state.tau);
    EXPECT_GT(state.dq.norm(), 0.0);
    EXPECT_NEAR(power, state.actuator_dq.dot(state.actuator_tau), 1e-12 * (1.0 + std::abs(power)));
  }
}

// Torque to bits, bits measured by a perfect board, and back: half a bit of current per actuator.
TEST_P(OnEveryCoupling, TorqueSurvivesItsConversionToHalfABitOfCurrent) {
  ArmUnits units(robot, K);
  Random random(6);
  std::vector<RawActuator> raw(n);
  BoardArmState state(n);
  ArmCommand command(n);
  for (int trial = 0; trial < 20; ++trial) {
    VectorXd currents(n);
    VectorXd actuator_tau(n);
    for (int i = 0; i < n; ++i) {
      const ActuatorConfig& a = robot.actuators[i];
      currents[i] = random.in(-0.95, 0.95) * a.max_current;
      actuator_tau[i] = currents[i] / a.effort_to_amps;
    }
    const VectorXd tau = units.joint_to_actuator().transpose() * actuator_tau;
    units.write(tau, command);
    EXPECT_TRUE(command.valid);
    EXPECT_FALSE(command.clipped);
    EXPECT_TRUE(near(command.tau, tau, 1e-9));
    for (int i = 0; i < n; ++i)
      raw[i].current = command.bits[i];
    units.read(raw.data(), state);
    const double half_bit = 0.5 / 5242.88;
    EXPECT_TRUE(near(state.current, currents, half_bit * 1.0001));
  }
}

// Position to the preload word and back as an encoder that stands there: half a count.
TEST_P(OnEveryCoupling, PreloadedEncodersReadThePositionsOfThePots) {
  ArmUnits units(robot, K);
  Random random(7);
  std::vector<RawActuator> raw(n);
  std::vector<std::uint32_t> words(n);
  BoardArmState state(n);
  VectorXd actuator_q(n);
  for (int trial = 0; trial < 20; ++trial) {
    const VectorXd pots = random.vector(n, 10000.25, 55000.75);  // means of many readings
    units.pot_positions(pots, actuator_q);
    units.preload_words(actuator_q, words.data());
    for (int i = 0; i < n; ++i)
      raw[i].encoder.position = words[i];
    units.read(raw.data(), state);
    for (int i = 0; i < n; ++i) {
      const double count = std::abs(robot.actuators[i].bits_to_position);
      EXPECT_NEAR(state.actuator_q[i], actuator_q[i], 0.5001 * count);
    }
    EXPECT_TRUE(near(state.q, K * state.actuator_q, 1e-12));
  }
}

INSTANTIATE_TEST_SUITE_P(Arms, OnEveryCoupling,
                         testing::Values(CoupledArm{"PSM1", ""}, CoupledArm{"PSM2", kNeedleDriver},
                                         CoupledArm{"PSM3", "prograsp-400093"},
                                         CoupledArm{"MTML", ""}, CoupledArm{"MTMR", ""},
                                         CoupledArm{"ECM", ""}),
                         [](const auto& arm) {
                           return arm.param.arm + (arm.param.instrument.empty() ? "" : "_tool");
                         });

// Specification 16, by hand: joints of the master arm from its motors, and motors from its pots,
// which sit on the joints.
TEST(ArmUnits, TheMasterArmsCouplingMatchesTheSpecification) {
  const ArmFacts facts = read_arm("MTML");
  const RobotConfig robot = nominal_config(facts).robots.at(0);
  ArmUnits units(robot, facts.coupling());
  VectorXd motors(7);
  motors << 0.1, 0.2, 0.5, 0.7, 0, 0, 0;
  std::vector<RawActuator> raw(7);
  std::vector<std::uint32_t> words(7);
  units.preload_words(motors, words.data());
  for (std::size_t i = 0; i < 7; ++i) raw[i].encoder.position = words[i];
  BoardArmState state(7);
  units.read(raw.data(), state);
  const double kCounts = 1e-4;  // two counts of the coarsest encoder in the first four
  EXPECT_NEAR(state.q[2], 0.5 - 0.2, kCounts);
  EXPECT_NEAR(state.q[3], 0.7 + 0.6697 * (0.2 - 0.5), 2 * kCounts);
  // The pots of these joints give these motors.
  VectorXd pots(7);
  for (int i = 0; i < 7; ++i) {
    const ActuatorConfig& a = robot.actuators[i];
    pots[i] = a.bits_to_volts.inverse(a.volts_to_position.inverse(state.q[i]));
  }
  VectorXd from_pots(7);
  units.pot_positions(pots, from_pots);
  EXPECT_TRUE(near(from_pots, state.actuator_q, 1e-9));
}

TEST(ArmUnits, CurrentsAreHeldWithinTheirLimits) {
  const RobotConfig robot = example();
  ArmUnits units(robot);
  ArmCommand command(7);
  units.write(VectorXd::Constant(7, 1e6), command);
  EXPECT_TRUE(command.clipped);
  for (std::size_t i = 0; i < 7; ++i) {
    const ActuatorConfig& a = robot.actuators[i];
    EXPECT_EQ(command.current[static_cast<int>(i)], a.max_current);
    EXPECT_NEAR(command.bits[i], a.amps_to_bits(a.max_current), 0.5);
    EXPECT_NEAR(command.tau[static_cast<int>(i)], a.max_current / a.effort_to_amps, 1e-12);
  }
}

TEST(ArmUnits, NonFiniteValuesBecomeZeroCurrent) {
  const RobotConfig robot = example();
  ArmUnits units(robot, read_arm("PSM1").coupling(kNeedleDriver));
  ArmCommand command(7);
  VectorXd tau = VectorXd::Constant(7, 0.01);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    tau[5] = bad;
    units.write(tau, command);
    EXPECT_FALSE(command.valid);
    for (std::size_t i = 0; i < 7; ++i)
      EXPECT_EQ(command.bits[i], std::lround(robot.actuators[i].amps_to_bits.offset));
  }
  units.write(VectorXd::Zero(3), command);
  EXPECT_FALSE(command.valid);
}

TEST(ArmUnits, SoftwareVelocityIsTheDifferenceOfCounts) {
  RobotConfig robot = example();
  robot.actuators[2].velocity_source = VelocitySource::kSoftware;
  ArmUnits units(robot);
  std::vector<RawActuator> raw(7);
  BoardArmState state(7);
  raw[2].encoder.position = preload_word(1000);
  raw[2].seconds = 0.001;
  units.read(raw.data(), state);
  EXPECT_EQ(state.dq[2], 0.0);  // there is no previous sample
  raw[2].encoder.position = preload_word(1200);
  units.read(raw.data(), state);
  EXPECT_NEAR(state.dq[2], 200.0 / 0.001 * robot.actuators[2].bits_to_position, 1e-12);
  raw[2].encoder.position = preload_word(-50000);
  units.reset();
  units.read(raw.data(), state);
  EXPECT_EQ(state.dq[2], 0.0);
}

TEST(ArmUnits, CouplingsThatCannotBeInvertedAreRefused) {
  MatrixXd K = MatrixXd::Identity(7, 7);
  K(3, 3) = 0.0;
  EXPECT_THROW(ArmUnits(example(), K), InvalidInput);
  EXPECT_THROW(ArmUnits(example(), MatrixXd::Identity(6, 6)), InvalidInput);
  EXPECT_THROW(ArmUnits(RobotConfig{}), InvalidInput);
}

}  // namespace
}  // namespace veridyn::dvrk
