#include "dvrk/config/io_config.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/near.hpp"
#include "support/refusal.hpp"
#include "dvrk/arms/arm_facts.hpp"
#include "dvrk/arms/arm_units.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

const std::string kExample =
    std::string(VERIDYN_SOURCE_DIR) + "/data/dvrk/sawRobotIO1394-PSM1-example.xml";
constexpr double kDegree = M_PI / 180.0;

void expect_scale(const LinearScale& a, const LinearScale& b) {
  EXPECT_NEAR(a.scale, b.scale, 1e-14 * std::abs(b.scale));
  EXPECT_NEAR(a.offset, b.offset, 1e-14 * (1.0 + std::abs(b.offset)));
}

void expect_same(const ActuatorConfig& a, const ActuatorConfig& b) {
  EXPECT_EQ(a.board, b.board);
  EXPECT_EQ(a.axis, b.axis);
  EXPECT_EQ(a.prismatic, b.prismatic);
  EXPECT_EQ(a.velocity_source, b.velocity_source);
  expect_scale(a.amps_to_bits, b.amps_to_bits);
  expect_scale(a.bits_to_amps, b.bits_to_amps);
  expect_scale(a.bits_to_volts, b.bits_to_volts);
  expect_scale(a.volts_to_position, b.volts_to_position);
  EXPECT_NEAR(a.effort_to_amps, b.effort_to_amps, 1e-15);
  EXPECT_NEAR(a.max_current, b.max_current, 1e-15);
  EXPECT_NEAR(a.bits_to_position, b.bits_to_position, 1e-15 * std::abs(b.bits_to_position));
  EXPECT_NEAR(a.lower, b.lower, 1e-14);
  EXPECT_NEAR(a.upper, b.upper, 1e-14);
  ASSERT_EQ(a.brake.has_value(), b.brake.has_value());
  if (!a.brake) return;
  EXPECT_EQ(a.brake->board, b.brake->board);
  EXPECT_EQ(a.brake->axis, b.brake->axis);
  EXPECT_EQ(a.brake->release_current, b.brake->release_current);
  EXPECT_EQ(a.brake->release_time, b.brake->release_time);
  EXPECT_EQ(a.brake->released_current, b.brake->released_current);
  EXPECT_EQ(a.brake->engaged_current, b.brake->engaged_current);
  EXPECT_EQ(a.brake->max_current, b.brake->max_current);
  expect_scale(a.brake->amps_to_bits, b.brake->amps_to_bits);
}

void expect_same(const IoConfig& a, const IoConfig& b) {
  ASSERT_EQ(a.robots.size(), b.robots.size());
  for (std::size_t r = 0; r < a.robots.size(); ++r) {
    const RobotConfig& x = a.robots[r];
    const RobotConfig& y = b.robots[r];
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(x.hardware, y.hardware);
    EXPECT_EQ(x.serial, y.serial);
    ASSERT_EQ(x.board_serials.size(), y.board_serials.size());
    for (std::size_t k = 0; k < x.board_serials.size(); ++k) {
      EXPECT_EQ(x.board_serials[k].board, y.board_serials[k].board);
      EXPECT_EQ(x.board_serials[k].serial, y.board_serials[k].serial);
    }
    EXPECT_EQ(x.io_only, y.io_only);
    EXPECT_EQ(x.has_encoder_preload, y.has_encoder_preload);
    EXPECT_EQ(x.pot_lookup_table, y.pot_lookup_table);
    EXPECT_TRUE(near(x.pots_to_actuators, y.pots_to_actuators, 0.0));
    ASSERT_EQ(x.size(), y.size());
    for (std::size_t k = 0; k < x.actuators.size(); ++k)
      expect_same(x.actuators[k], y.actuators[k]);
    ASSERT_EQ(x.pot_tolerances.size(), y.pot_tolerances.size());
    for (std::size_t k = 0; k < x.pot_tolerances.size(); ++k) {
      EXPECT_EQ(x.pot_tolerances[k].axis, y.pot_tolerances[k].axis);
      EXPECT_NEAR(x.pot_tolerances[k].distance, y.pot_tolerances[k].distance, 1e-15);
      EXPECT_EQ(x.pot_tolerances[k].latency, y.pot_tolerances[k].latency);
    }
  }
  ASSERT_EQ(a.digital_inputs.size(), b.digital_inputs.size());
  for (std::size_t k = 0; k < a.digital_inputs.size(); ++k) {
    const DigitalInputConfig& x = a.digital_inputs[k];
    const DigitalInputConfig& y = b.digital_inputs[k];
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(x.board, y.board);
    EXPECT_EQ(x.bit, y.bit);
    EXPECT_EQ(x.pressed_when_low, y.pressed_when_low);
    EXPECT_EQ(x.trigger, y.trigger);
    EXPECT_NEAR(x.debounce, y.debounce, 1e-15);
    EXPECT_NEAR(x.debounce_click, y.debounce_click, 1e-15);
    EXPECT_EQ(x.skip_first_run, y.skip_first_run);
  }
  ASSERT_EQ(a.digital_outputs.size(), b.digital_outputs.size());
  for (std::size_t k = 0; k < a.digital_outputs.size(); ++k) {
    EXPECT_EQ(a.digital_outputs[k].name, b.digital_outputs[k].name);
    EXPECT_EQ(a.digital_outputs[k].board, b.digital_outputs[k].board);
    EXPECT_EQ(a.digital_outputs[k].bit, b.digital_outputs[k].bit);
    EXPECT_EQ(a.digital_outputs[k].high_duration, b.digital_outputs[k].high_duration);
    EXPECT_EQ(a.digital_outputs[k].low_duration, b.digital_outputs[k].low_duration);
    EXPECT_EQ(a.digital_outputs[k].frequency, b.digital_outputs[k].frequency);
  }
  ASSERT_EQ(a.dallas_chips.size(), b.dallas_chips.size());
  for (std::size_t k = 0; k < a.dallas_chips.size(); ++k) {
    EXPECT_EQ(a.dallas_chips[k].name, b.dallas_chips[k].name);
    EXPECT_EQ(a.dallas_chips[k].board, b.dallas_chips[k].board);
  }
}

// Everything that a configuration can have.
IoConfig full_config() {
  IoConfig config = read_io_config(kExample);
  config.robots[0].serial = "4711";
  config.robots[0].board_serials = {{6, "1234-56"}, {7, "1234-57"}};
  config.robots[0].actuators[2].velocity_source = VelocitySource::kSoftware;
  const IoConfig ecm = nominal_config(read_arm("ECM"));
  const IoConfig mtm = nominal_config(read_arm("MTML"));
  config.robots.push_back(ecm.robots[0]);
  config.robots.push_back(mtm.robots[0]);
  config.robots[2].has_encoder_preload = false;
  config.robots[2].pot_lookup_table = "pots.json";
  config.robots[2].io_only = true;
  config.digital_inputs[1].skip_first_run = true;
  config.digital_inputs[1].pressed_when_low = false;
  config.digital_inputs[1].trigger = "press";
  config.digital_outputs.push_back({"PSM1-lamp", 7, 2, 0.5, 1.5, 0.0});
  config.digital_outputs.push_back({"PSM1-fan", 7, 3, 0.0, 0.0, 40.0});
  return config;
}

TEST(IoConfig, TheExampleIsReadInSiUnits) {
  const IoConfig config = read_io_config(kExample);
  EXPECT_TRUE(config.remarks.empty()) << config.remarks.front();
  const RobotConfig& psm = config.robot("PSM1");
  EXPECT_EQ(&psm, &config.robot());
  ASSERT_EQ(psm.size(), 7);
  EXPECT_EQ(psm.actuators[3].board, 6);
  EXPECT_EQ(psm.actuators[4].board, 7);
  EXPECT_TRUE(psm.actuators[2].prismatic);
  // Specification 12: SI values of the same numbers.
  EXPECT_NEAR(psm.actuators[0].bits_to_position, -7.7226958e-6, 1e-13);
  EXPECT_NEAR(psm.actuators[2].bits_to_position, 1.2962933e-6, 1e-13);
  EXPECT_NEAR(psm.actuators[5].bits_to_position, 1.3414145e-4, 1e-11);
  EXPECT_NEAR(psm.actuators[0].upper, 91.0 * kDegree, 1e-12);
  EXPECT_NEAR(psm.actuators[2].upper, 0.24, 1e-12);
  EXPECT_NEAR(psm.pot_tolerances[2].distance, 0.005, 1e-15);
  EXPECT_NEAR(psm.pot_tolerances[6].distance, 5.0 * kDegree, 1e-15);
  EXPECT_EQ(config.digital_inputs.size(), 4U);
  EXPECT_NEAR(config.digital_inputs[0].debounce_click, 0.04, 1e-15);  // 20 % of 0.2 s
}

TEST(IoConfig, AnInputIsPressedAtItsConfiguredLevel) {
  DigitalInputConfig input;
  input.bit = 7;
  input.pressed_when_low = true;
  EXPECT_TRUE(input.value(0x00));
  EXPECT_FALSE(input.value(0x80));
  input.pressed_when_low = false;
  EXPECT_TRUE(input.value(0x80));
}

TEST(IoConfig, XmlRoundTripKeepsEveryValue) {
  const IoConfig config = full_config();
  const IoConfig back = read_io_xml(to_io_xml(config), "back.xml");
  expect_same(back, config);
  EXPECT_TRUE(back.remarks.empty()) << back.remarks.front();
}

TEST(IoConfig, JsonRoundTripKeepsEveryValue) {
  const IoConfig config = full_config();
  const IoConfig back = read_io_json(to_io_json(config), "back.json");
  expect_same(back, config);
  EXPECT_TRUE(back.remarks.empty()) << back.remarks.front();
}

// By hand, with the names of specification 15.1, an editor's comment on top, and a member that
// is unknown.
TEST(IoConfig, HandWrittenJsonIsRead) {
  const std::string json = R"(/* -*- Mode: Javascript -*- */
{ "$id": "saw-robot-io.schema.json", "$version": "6",
  "robots": [ { "name": "one", "hardware_version": "QLA1", "serial_number": "12", "colour": "red",
    "actuators": [ { "board_id": 3, "axis_id": 1, "joint_type": "PRISMATIC",
      "drive": { "current_to_bits": { "scale": 5242.88, "offset": 32800 },
                 "bits_to_current": { "scale": 0.000190735, "offset": -6.25 },
                 "effort_to_current": { "scale": 0.5 }, "maximum_current": 0.7 },
      "encoder": { "velocity_source": "SOFTWARE", "bits_to_position": { "scale": 1e-6 },
                   "position_limits_soft": { "lower": 0, "upper": 0.24 } },
      "potentiometer": { "bits_to_voltage": { "scale": 6.8665e-5, "offset": 0.0 },
                         "voltage_to_position": { "scale": 0.0592, "offset": -0.021 } } } ] } ] })";
  const IoConfig config = read_io_json(json, "hand.json");
  const ActuatorConfig& actuator = config.robot("one").actuators.at(0);
  EXPECT_EQ(actuator.board, 3);
  EXPECT_TRUE(actuator.prismatic);
  EXPECT_EQ(actuator.max_current, 0.7);
  EXPECT_EQ(actuator.upper, 0.24);
  EXPECT_EQ(actuator.velocity_source, VelocitySource::kSoftware);
  ASSERT_EQ(config.remarks.size(), 1U);
  EXPECT_NE(config.remarks[0].find("robots/colour"), std::string::npos) << config.remarks[0];
}

// Lists without items, as programs write them: nothing is there, and nothing is wrong.
TEST(IoConfig, EmptyJsonListsAddNothing) {
  std::string json = to_io_json(nominal_config(read_arm("PSM1")));
  json.replace(json.rfind('}'), 1, R"(, "digital_inputs": [], "digital_outputs": [], "dallas_chips": [] })");
  json.replace(json.find("\"joint_type\""), 0, "\"brakes\": [], ");
  const auto pots = json.find("\"potentiometers\": {");
  ASSERT_NE(pots, std::string::npos);
  json.replace(pots, 19, "\"potentiometers\": { \"joint_to_actuator_position\": [], ");
  const IoConfig config = read_io_json(json, "lists.json");
  EXPECT_TRUE(config.remarks.empty()) << config.remarks.front();
  expect_same(config, nominal_config(read_arm("PSM1")));
  EXPECT_TRUE(read_io_json("{\"robots\": []}", "lists.json").robots.empty());
}

// Values that a format cannot represent are not written.
TEST(IoConfig, NumbersThatAFileCannotHoldAreRefused) {
  IoConfig config = read_io_config(kExample);
  config.robots[0].actuators[2].upper = 1e306;  // [m]
  EXPECT_NO_THROW(to_io_json(config));
  EXPECT_TRUE(refuses_with("found inf as Upper to write", [&] { to_io_xml(config); }));
  config.robots[0].actuators[2].upper = std::nan("");
  EXPECT_TRUE(refuses_with("found nan as Upper to write", [&] { to_io_json(config); }));
}

// A gripper: a pot and nothing else. It is read and written, but is no arm to drive.
TEST(IoConfig, AnInputOnlyRobotIsReadAndCannotBeDriven) {
  const std::string xml = R"(<Config Version="5">
  <Robot Name="MTML-Gripper" HardwareVersion="QLA1" NumOfActuator="1" Type="io-only">
    <Actuator ActuatorID="0" BoardID="1" AxisID="3" Type="Revolute">
      <AnalogIn>
        <BitsToVolts Scale="6.8665e-05" Offset="0"/>
        <VoltsToPosSI Scale="-38.7" Offset="94.8" Unit="deg"/>
      </AnalogIn>
    </Actuator>
  </Robot>
</Config>)";
  const IoConfig config = read_io_xml(xml, "io.xml");
  EXPECT_TRUE(config.remarks.empty());
  EXPECT_TRUE(config.robot().io_only);
  expect_same(read_io_xml(to_io_xml(config), "back.xml"), config);
  expect_same(read_io_json(to_io_json(config), "back.json"), config);
  EXPECT_THROW(ArmUnits{config.robot()}, InvalidInput);
  std::string robot = xml;
  robot.replace(robot.find("io-only"), 7, "robot");
  EXPECT_THROW(read_io_xml(robot, "io.xml"), InvalidInput);
}

TEST(IoConfig, ACurrentSignOppositeToThePositionIsRemarked) {
  IoConfig config = read_io_config(kExample);
  config.robots[0].actuators[4].bits_to_position *= -1.0;
  const IoConfig back = read_io_xml(to_io_xml(config), "io.xml");
  ASSERT_EQ(back.remarks.size(), 1U);
  EXPECT_NE(back.remarks[0].find("PSM1 actuator 4"), std::string::npos) << back.remarks[0];
}

}  // namespace
}  // namespace veridyn::dvrk
