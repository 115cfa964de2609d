#include <charconv>
#include <cmath>

#include "config_tree.hpp"
#include "dvrk/config/io_config.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

// The shortest decimal text that reads as the same number.
std::string shortest_decimal(double value) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof(buffer), value).ptr;
  return {buffer, end};
}

ConfigTree element(const std::string& name) {
  ConfigTree tree;
  tree.name = name;
  return tree;
}

void add_text(ConfigTree& tree, const std::string& name, const std::string& value) {
  ConfigTree& member = tree.members.emplace_back(element(name));
  member.scalar = true;
  member.text = value;
}

void add_number(ConfigTree& tree, const std::string& name, double value) {
  require(std::isfinite(value), "configuration: found ", value, " as ", name, " to write, expected a finite number.");
  add_text(tree, name, shortest_decimal(value));
  tree.members.back().quoted = false;
}

class Writer {
 public:
  explicit Writer(ConfigFormat format) : json_(format == ConfigFormat::kJson) {}

  ConfigTree write(const IoConfig& config) const {
    ConfigTree root = element("Config");
    if (json_) {
      add_text(root, "$id", "saw-robot-io.schema.json");
      add_text(root, "$version", "6");
    } else {
      add_number(root, "Version", 5);
    }
    for (const RobotConfig& robot : config.robots) add_item(root, robot_tree(robot));
    for (const DigitalInputConfig& input : config.digital_inputs) add_item(root, input_tree(input));
    for (const DigitalOutputConfig& output : config.digital_outputs)
      add_item(root, output_tree(output));
    for (const DallasChipConfig& chip : config.dallas_chips) {
      ConfigTree tree = element("DallasChip");
      add_text(tree, "Name", chip.name);
      add_number(tree, "BoardID", chip.board);
      add_item(root, tree);
    }
    return root;
  }

 private:
  static void add_item(ConfigTree& parent, ConfigTree item) {
    item.listed = true;
    parent.members.push_back(std::move(item));
  }

  void add_flag(ConfigTree& tree, const std::string& name, bool value) const {
    add_text(tree, name, json_ ? (value ? "true" : "false") : (value ? "True" : "False"));
    tree.members.back().quoted = !json_;
  }

  // XML has degrees and millimetres, as in files of sawRobotIO1394.
  double file_unit(double si, bool prismatic) const {
    if (json_) return si;
    return prismatic ? 1e3 * si : si * 180.0 / M_PI;
  }

  void add_unit(ConfigTree& tree, bool prismatic) const {
    if (!json_) add_text(tree, "Unit", prismatic ? "mm" : "deg");
  }

  static void add_scale(ConfigTree& tree, const std::string& name, const LinearScale& scale) {
    ConfigTree& member = tree.members.emplace_back(element(name));
    add_number(member, "Scale", scale.scale);
    add_number(member, "Offset", scale.offset);
  }

  static void add_value(ConfigTree& tree, const std::string& name, double value) {
    add_number(tree.members.emplace_back(element(name)), "Value", value);
  }

  ConfigTree robot_tree(const RobotConfig& robot) const {
    ConfigTree tree = element("Robot");
    add_text(tree, "Name", robot.name);
    add_text(tree, "HardwareVersion", robot.hardware);
    add_number(tree, "NumOfActuator", robot.size());
    if (!robot.serial.empty()) add_text(tree, "SN", robot.serial);
    std::string serials;
    for (const BoardSerial& one : robot.board_serials)
      serials += text(serials.empty() ? "" : " ", one.board, "=", one.serial);
    if (!serials.empty()) add_text(tree, "BoardSerials", serials);
    if (robot.io_only) {
      if (json_)
        add_flag(tree, "OnlyIO", true);
      else
        add_text(tree, "Type", "io-only");
    }
    if (!robot.has_encoder_preload) add_flag(tree, "HasEncoderPreload", false);
    for (int k = 0; k < robot.size(); ++k)
      add_item(tree, actuator_tree(robot.actuators[k], k));
    const bool pots = robot.pots_to_actuators.size() > 0 || !robot.pot_tolerances.empty() ||
                      !robot.pot_lookup_table.empty();
    if (pots) tree.members.push_back(potentiometers(robot));
    return tree;
  }

  ConfigTree actuator_tree(const ActuatorConfig& actuator, int index) const {
    ConfigTree tree = element("Actuator");
    if (!json_) add_number(tree, "ActuatorID", index);
    add_number(tree, "BoardID", actuator.board);
    add_number(tree, "AxisID", actuator.axis);
    add_text(tree, json_ ? "JointType" : "Type",
             json_ ? (actuator.prismatic ? "PRISMATIC" : "REVOLUTE")
                   : (actuator.prismatic ? "Prismatic" : "Revolute"));
    if (actuator.max_current > 0.0) tree.members.push_back(drive(actuator));
    if (actuator.bits_to_position != 0.0) tree.members.push_back(encoder(actuator));
    ConfigTree pot = element("AnalogIn");
    add_scale(pot, "BitsToVolts", actuator.bits_to_volts);
    const LinearScale& volts = actuator.volts_to_position;
    add_scale(
        pot, "VoltsToPosSI",
        {file_unit(volts.scale, actuator.prismatic), file_unit(volts.offset, actuator.prismatic)});
    add_unit(pot.members.back(), actuator.prismatic);
    tree.members.push_back(std::move(pot));
    if (actuator.brake) add_item(tree, brake_tree(*actuator.brake));
    return tree;
  }

  static ConfigTree drive(const ActuatorConfig& actuator) {
    ConfigTree tree = element("Drive");
    add_current(tree, actuator.amps_to_bits, actuator.bits_to_amps, actuator.max_current);
    add_number(tree.members.emplace_back(element("NmToAmps")), "Scale", actuator.effort_to_amps);
    return tree;
  }

  static void add_current(ConfigTree& tree, const LinearScale& to_bits, const LinearScale& to_amps,
                          double max_current) {
    add_scale(tree, "AmpsToBits", to_bits);
    add_scale(tree, "BitsToFeedbackAmps", to_amps);
    add_value(tree, "MaxCurrent", max_current);
  }

  ConfigTree encoder(const ActuatorConfig& actuator) const {
    ConfigTree tree = element("Encoder");
    const bool firmware = actuator.velocity_source == VelocitySource::kFirmware;
    add_text(tree, "VelocitySource", firmware ? "FIRMWARE" : "SOFTWARE");
    ConfigTree bits = element("BitsToPosSI");
    add_number(bits, "Scale", file_unit(actuator.bits_to_position, actuator.prismatic));
    add_unit(bits, actuator.prismatic);
    tree.members.push_back(std::move(bits));
    ConfigTree limits = element("PositionLimitsSoft");
    add_number(limits, "Lower", file_unit(actuator.lower, actuator.prismatic));
    add_number(limits, "Upper", file_unit(actuator.upper, actuator.prismatic));
    add_unit(limits, actuator.prismatic);
    tree.members.push_back(std::move(limits));
    return tree;
  }

  static ConfigTree brake_tree(const BrakeConfig& brake) {
    ConfigTree tree = element("AnalogBrake");
    add_number(tree, "BoardID", brake.board);
    add_number(tree, "AxisID", brake.axis);
    add_current(tree, brake.amps_to_bits, brake.bits_to_amps, brake.max_current);
    add_value(tree, "ReleaseCurrent", brake.release_current);
    add_value(tree, "ReleaseTime", brake.release_time);
    add_value(tree, "ReleasedCurrent", brake.released_current);
    add_value(tree, "EngagedCurrent", brake.engaged_current);
    return tree;
  }

  ConfigTree potentiometers(const RobotConfig& robot) const {
    ConfigTree tree = element("Potentiometers");
    if (!robot.pot_lookup_table.empty()) add_text(tree, "LookupTable", robot.pot_lookup_table);
    if (robot.pots_to_actuators.size() > 0) add_matrix(tree, robot.pots_to_actuators);
    for (const PotTolerance& tolerance : robot.pot_tolerances) {
      const bool prismatic = robot.actuators[tolerance.axis].prismatic;
      ConfigTree item = element("Tolerance");
      add_number(item, "Axis", tolerance.axis);
      add_number(item, "Distance", file_unit(tolerance.distance, prismatic));
      add_number(item, "Latency", tolerance.latency);
      add_unit(item, prismatic);
      add_item(tree, std::move(item));
    }
    return tree;
  }

  void add_matrix(ConfigTree& tree, const MatrixXd& matrix) const {
    ConfigTree rows = element("JointToActuatorPosition");
    for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
      std::string numbers;
      for (Eigen::Index column = 0; column < matrix.cols(); ++column)
        numbers += (column == 0 ? "" : json_ ? "," : " ") + shortest_decimal(matrix(row, column));
      if (json_) {
        add_text(tree, rows.name, "[" + numbers + "]");
        tree.members.back().quoted = false;
        tree.members.back().listed = true;
      } else {
        add_text(rows.members.emplace_back(element("Row")), "Val", numbers);
      }
    }
    if (!json_) tree.members.push_back(std::move(rows));
  }

  ConfigTree input_tree(const DigitalInputConfig& input) const {
    ConfigTree tree = element("DigitalIn");
    add_text(tree, "Name", input.name);
    add_number(tree, "BoardID", input.board);
    add_number(tree, "BitID", input.bit);
    add_number(tree, "Pressed", input.pressed_when_low ? 1 : 0);
    add_text(tree, "Trigger", input.trigger);
    add_number(tree, "Debounce", input.debounce);
    add_number(tree, "DebounceClick", input.debounce_click);
    if (input.skip_first_run) add_flag(tree, "SkipFirstRun", true);
    return tree;
  }

  static ConfigTree output_tree(const DigitalOutputConfig& output) {
    ConfigTree tree = element("DigitalOut");
    add_text(tree, "Name", output.name);
    add_number(tree, "BoardID", output.board);
    add_number(tree, "BitID", output.bit);
    add_number(tree, "HighDuration", output.high_duration);
    add_number(tree, "LowDuration", output.low_duration);
    if (output.frequency > 0.0) add_number(tree, "Frequency", output.frequency);
    return tree;
  }

  bool json_;
};

}  // namespace

std::string to_io_xml(const IoConfig& config) {
  return print_config(Writer(ConfigFormat::kXml).write(config), ConfigFormat::kXml);
}

std::string to_io_json(const IoConfig& config) {
  return print_config(Writer(ConfigFormat::kJson).write(config), ConfigFormat::kJson);
}

}  // namespace veridyn::dvrk
