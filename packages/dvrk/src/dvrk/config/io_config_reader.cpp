#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "config_tree.hpp"
#include "dvrk/config/io_config.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

constexpr int kBoards = 16;
// Larger than the travel of any joint of these arms: a master's roll makes 2.6 turns, an endoscope moves by
// 0.25 m.
constexpr double kMostTurns = 3.0;
constexpr double kMostSlide = 1.0;  // [m]
// A pot covers 0.9 to 1.1 times the travel of the soft limits, which a user may reduce to some per
// cent. Limits in radians that are read as degrees are 1/57 of the travel.
constexpr double kLeastOfPot = 0.025, kMostOfPot = 8.0;

// Factor to rad or m. A revolute joint has no millimetres. Without a unit it is 1 if `has_default` (JSON, which
// uses SI).
double unit_factor(const ConfigNode& node, bool prismatic, bool has_default) {
  if (has_default && !node.has("Unit")) return 1.0;
  node.word("Unit");
  if (!prismatic) return node.choice("Unit", {"rad", "deg"}, 0) == 0 ? 1.0 : M_PI / 180.0;
  constexpr double kFactors[] = {1e-3, 1e-2, 1.0};
  return kFactors[node.choice("Unit", {"mm", "cm", "m"}, 0)];
}

// A distance in mm or deg, with its unit.
std::string distance_text(double distance, bool prismatic) {
  return prismatic ? text(1e3 * distance, " mm") : text(180.0 / M_PI * distance, " deg");
}

// Refuses limits whose unit contradicts the pot's, or that no joint can have.
void require_plausible(const ConfigNode& actuator, const ActuatorConfig& it, bool pots_scaled) {
  if (!actuator.has("Encoder")) return;
  const ConfigNode limits = actuator.at("Encoder").at("PositionLimitsSoft");
  const double travel = it.upper - it.lower;
  const double most = it.prismatic ? kMostSlide : kMostTurns * 2.0 * M_PI;
  if (!(travel <= most))
    limits.fail(text("a travel of ", distance_text(travel, it.prismatic)),
                text("at most ", distance_text(most, it.prismatic),
                     ", which no joint exceeds: its Unit is that of other numbers"));
  const double pot = std::abs(it.volts_to_position.scale * it.bits_to_volts.scale) * 65536.0;
  const double share = travel / pot;
  if (pots_scaled && !(share >= kLeastOfPot && share <= kMostOfPot))
    limits.fail(text("a travel of ", distance_text(travel, it.prismatic), ", where VoltsToPosSI covers ",
                     distance_text(pot, it.prismatic)),
                text("a share of ", kLeastOfPot, " to ", kMostOfPot, " of it: the Unit of one of them is that of other numbers"));
}

LinearScale read_scale(const ConfigNode& node) {
  return {node.nonzero("Scale"), node.number("Offset", 0.0)};
}

class Reader {
 public:
  explicit Reader(ConfigSource& source) : json_(source.format == ConfigFormat::kJson) {}

  IoConfig read(const ConfigNode& root) const {
    check_version(root);
    IoConfig config;
    for (const ConfigNode& robot : root.items("Robot")) config.robots.push_back(read_robot(robot));
    for (const ConfigNode& input : root.items("DigitalIn")) config.digital_inputs.push_back(read_input(input));
    for (const ConfigNode& output : root.items("DigitalOut")) config.digital_outputs.push_back(read_output(output));
    for (const ConfigNode& chip : root.items("DallasChip")) config.dallas_chips.push_back({chip.word("Name"), board(chip)});
    return config;
  }

 private:
  static int board(const ConfigNode& node) { return node.integer_in("BoardID", 0, kBoards - 1); }

  void check_version(const ConfigNode& root) const {
    if (json_) {
      root.word("$id", "");
      if (root.word("$version", "6") != "6")
        root.at("$version").fail("'" + root.word("$version") + "'", "version 6");
    } else if (const double version = root.number("Version"); version != 5.0) {
      root.at("Version").fail(text(version), "version 5 (older files use other names and units)");
    }
  }

  RobotConfig read_robot(const ConfigNode& node) const {
    RobotConfig robot;
    robot.name = node.word("Name");
    const std::vector<std::string> hardware{"QLA1", "DQLA", "dRA1"};
    node.word("HardwareVersion");
    robot.hardware =
        hardware[node.choice("HardwareVersion", hardware, 0)];
    robot.serial = node.word("SN", "");
    if (node.has("BoardSerials")) read_board_serials(node.at("BoardSerials"), robot);
    robot.io_only =
        json_ ? node.flag("OnlyIO", false) : node.choice("Type", {"robot", "io-only"}, 0) == 1;
    robot.has_encoder_preload = node.flag("HasEncoderPreload", true);
    node.number("NumOfJoint", 0.0);
    read_actuators(node, robot);
    const bool pots_scaled =
        !node.has("Potentiometers") || node.at("Potentiometers").word("LookupTable", "").empty();
    const std::vector<ConfigNode> actuators = node.items("Actuator");
    for (std::size_t k = 0; k < actuators.size(); ++k)
      require_plausible(actuators[k], robot.actuators[k], pots_scaled);
    if (node.has("Potentiometers")) read_potentiometers(node.at("Potentiometers"), robot);
    return robot;
  }

  // "6=1234-56 7=1234-57": a key of veridyn, which the dVRK software ignores.
  static void read_board_serials(const ConfigNode& node, RobotConfig& robot) {
    std::istringstream list(node.word());
    for (std::string one; list >> one;) {
      const auto equals = one.find('=');
      char* end = nullptr;
      const long id = std::strtol(one.c_str(), &end, 10);
      if (equals == std::string::npos || end != one.c_str() + equals || equals == 0 || id < 0 ||
          id >= kBoards || equals + 1 == one.size())
        node.fail("'" + one + "'", "BOARD=SERIAL, as 6=1234-56");
      robot.board_serials.push_back({static_cast<int>(id), one.substr(equals + 1)});
    }
  }

  void read_actuators(const ConfigNode& node, RobotConfig& robot) const {
    const int there = node.count("Actuator");
    // In JSON the number is the length of the list.
    if (!json_ || node.has("NumOfActuator")) {
      const int promised = node.integer_in("NumOfActuator", 0, 4 * kBoards);
      if (promised != there)
        node.fail(text(there, there == 1 ? " actuator" : " actuators"),
                  text(promised, ", as its number of actuators says"));
    }
    for (const ConfigNode& actuator : node.items("Actuator")) robot.actuators.push_back(read_actuator(actuator, robot));
  }

  // Robots with inputs and outputs only (grippers with a pot) may have no motor and encoder.
  ActuatorConfig read_actuator(const ConfigNode& node, const RobotConfig& robot) const {
    const std::string& hardware = robot.hardware;
    ActuatorConfig actuator;
    node.number("ActuatorID", 0.0);
    actuator.board = board(node);
    actuator.axis = node.integer_in("AxisID", 0, hardware == "QLA1" ? 3 : 9);
    actuator.prismatic =
        node.choice(json_ ? "JointType" : "Type", {"Revolute", "Prismatic"}, 0) == 1;
    if (!robot.io_only || node.has("Drive")) read_drive(node.at("Drive"), actuator);
    if (!robot.io_only || node.has("Encoder")) read_encoder(node.at("Encoder"), actuator);
    const ConfigNode pot = node.at("AnalogIn");
    actuator.bits_to_volts = read_scale(pot.at("BitsToVolts"));
    const ConfigNode volts = pot.at("VoltsToPosSI");
    const double unit = unit_factor(volts, actuator.prismatic, json_);
    actuator.volts_to_position = {unit * volts.nonzero("Scale"),
                                  unit * volts.number("Offset", 0.0)};
    if (node.has("AnalogBrake")) actuator.brake = read_brake(node.at("AnalogBrake"), hardware);
    return actuator;
  }

  static void read_current(const ConfigNode& node, LinearScale& to_bits, LinearScale& to_amps,
                           double& max_current) {
    to_bits = read_scale(node.at("AmpsToBits"));
    to_amps = read_scale(node.at("BitsToFeedbackAmps"));
    if (to_bits.scale * to_amps.scale < 0.0)
      node.at("BitsToFeedbackAmps")
          .fail(text("the scale ", to_amps.scale, " beside ", to_bits.scale, " for the command"),
                "two scales of one sign: measured and commanded current run the same way");
    max_current = node.value("MaxCurrent");
    if (!(max_current > 0.0)) node.at("MaxCurrent").fail("0", "a positive current");
    if (!node.at("MaxCurrent").has("Unit")) return;
    node.at("MaxCurrent").choice("Unit", {"A"}, 0);
  }

  static void read_drive(const ConfigNode& node, ActuatorConfig& actuator) {
    read_current(node, actuator.amps_to_bits, actuator.bits_to_amps, actuator.max_current);
    actuator.effort_to_amps = node.at("NmToAmps").positive("Scale");
  }

  void read_encoder(const ConfigNode& node, ActuatorConfig& actuator) const {
    actuator.velocity_source =
        static_cast<VelocitySource>(node.choice("VelocitySource", {"FIRMWARE", "SOFTWARE"}, 0));
    const ConfigNode bits = node.at("BitsToPosSI");
    actuator.bits_to_position =
        unit_factor(bits, actuator.prismatic, json_) * bits.nonzero("Scale");
    const ConfigNode limits = node.at("PositionLimitsSoft");
    const double unit = unit_factor(limits, actuator.prismatic, json_);
    actuator.lower = unit * limits.number("Lower");
    actuator.upper = unit * limits.number("Upper");
    if (!(actuator.lower < actuator.upper))
      limits.fail(text("limits from ", actuator.lower, " to ", actuator.upper),
                  "a lower limit below the upper one");
  }

  static BrakeConfig read_brake(const ConfigNode& node, const std::string& hardware) {
    BrakeConfig brake;
    brake.board = board(node);
    brake.axis = node.integer_in("AxisID", 0, hardware == "QLA1" ? 3 : 9);
    read_current(node, brake.amps_to_bits, brake.bits_to_amps, brake.max_current);
    brake.release_current = node.value("ReleaseCurrent");
    brake.release_time = node.value("ReleaseTime");
    brake.released_current = node.value("ReleasedCurrent");
    brake.engaged_current = node.value("EngagedCurrent");
    if (std::max({brake.release_current, brake.released_current, brake.engaged_current}) >
        brake.max_current)
      node.fail("a current above the brake's MaxCurrent", "currents up to it");
    return brake;
  }

  void read_potentiometers(const ConfigNode& node, RobotConfig& robot) const {
    robot.pot_lookup_table = node.word("LookupTable", "");
    if (node.has("JointToActuatorPosition"))
      robot.pots_to_actuators =
          json_ ? read_matrix(node, "JointToActuatorPosition", robot.size())
                : read_matrix(node.at("JointToActuatorPosition"), "Row", robot.size());
    for (const ConfigNode& item : node.items("Tolerance")) {
      const auto k = static_cast<int>(robot.pot_tolerances.size());
      PotTolerance tolerance;
      tolerance.axis = item.integer_in("Axis", 0, robot.size() - 1);
      if (tolerance.axis != k) item.fail(text("axis ", tolerance.axis), text("axis ", k, " here"));
      const bool prismatic = robot.actuators[k].prismatic;
      tolerance.distance = unit_factor(item, prismatic, json_) * item.not_negative("Distance", 0.0);
      tolerance.latency = item.not_negative("Latency", 0.0);
      const double travel = robot.actuators[k].upper - robot.actuators[k].lower;
      if (!robot.io_only && !(tolerance.distance < travel))
        item.fail(text("a distance of ", distance_text(tolerance.distance, prismatic)),
                  text("less than the travel of ", distance_text(travel, prismatic), " between the soft limits"));
      robot.pot_tolerances.push_back(tolerance);
    }
    if (!robot.pot_tolerances.empty() && node.count("Tolerance") != robot.size())
      node.fail(text(node.count("Tolerance"), " tolerances"), text(robot.size(), ", one per axis"));
  }

  // Rows of XML are <Row Val="1 0"/>, those of JSON lists of numbers.
  static MatrixXd read_matrix(const ConfigNode& node, const std::string& rows, int size) {
    MatrixXd matrix(size, size);
    const std::vector<ConfigNode> lines = node.items(rows);
    const auto count = static_cast<int>(lines.size());
    if (count != size) node.fail(text("a matrix of ", count, " rows"), text(size, ", one per actuator"));
    for (int row = 0; row < size; ++row) {
      const ConfigNode& line = lines[row];
      std::string numbers = line.has("Val") ? line.word("Val") : line.word();
      for (char& letter : numbers)
        if (letter == '[' || letter == ']' || letter == ',') letter = ' ';
      std::istringstream values(numbers);
      for (int column = 0; column < size; ++column) {
        if (!(values >> matrix(row, column)))
          line.fail(text("fewer than ", size, " numbers"), text(size, " numbers"));
      }
      std::string rest;
      if (values >> rest) line.fail("'" + rest + "' behind the row", text(size, " numbers"));
    }
    if (Eigen::FullPivLU<MatrixXd>(matrix).rank() < size)
      node.fail("a singular matrix", "one that can be inverted");
    return matrix;
  }

  static double seconds(const ConfigNode& node, const std::string& name, double fallback) {
    return node.not_negative(name, fallback);
  }

  static DigitalInputConfig read_input(const ConfigNode& node) {
    DigitalInputConfig input;
    input.name = node.word("Name");
    input.board = board(node);
    input.bit = node.integer_in("BitID", 0, 31);
    input.pressed_when_low = node.flag("Pressed", true);
    const std::vector<std::string> triggers{"all", "press", "release", "none"};
    // Two flags may replace the word: 1 pressed, 2 released.
    const int flags = (node.flag("trigger_when_pressed", true) ? 1 : 0) +
                      (node.flag("trigger_when_released", true) ? 2 : 0);
    const int by_flags[] = {3, 1, 2, 0};
    input.trigger =
        triggers[node.choice("Trigger", triggers, by_flags[flags])];
    input.debounce = seconds(node, "Debounce", 0.0);
    input.debounce_click = seconds(node, "DebounceClick", 0.2 * input.debounce);
    input.skip_first_run = node.flag("SkipFirstRun", false);
    return input;
  }

  static DigitalOutputConfig read_output(const ConfigNode& node) {
    DigitalOutputConfig output;
    output.name = node.word("Name");
    output.board = board(node);
    output.bit = node.integer_in("BitID", 0, 31);
    output.high_duration = seconds(node, "HighDuration", 0.0);
    output.low_duration = seconds(node, "LowDuration", 0.0);
    output.frequency = node.not_negative("Frequency", 0.0);
    return output;
  }

  bool json_;
};

IoConfig read(const std::string& content, const std::string& file, ConfigFormat format) {
  const ConfigTree tree = parse_config(content, file, format);
  if (format == ConfigFormat::kXml)
    require(tree.name == "Config", file, ": found the element <", tree.written,
            ">, expected <Config Version=\"5\">.");
  require(!tree.scalar, file, ": found JSON that is no object, expected {\"robots\": [...]}.");
  ConfigSource source{file, format, {}};
  IoConfig config = Reader(source).read(ConfigNode(tree, source, ""));
  check_io_config(config, file);
  config.remarks = unused(tree, source);
  for (const RobotConfig& robot : config.robots) {
    for (int k = 0; k < robot.size(); ++k) {
      const ActuatorConfig& a = robot.actuators[k];
      if (robot.io_only || a.amps_to_bits.scale * a.bits_to_position > 0.0) continue;
      config.remarks.push_back(text(file, ": ", robot.name, " actuator ", k,
                                    ": the scales of current and of position differ in sign; with "
                                    "the usual wiring positive current then moves it backwards."));
    }
  }
  return config;
}

}  // namespace

IoConfig read_io_xml(const std::string& content, const std::string& file) {
  return read(content, file, ConfigFormat::kXml);
}

IoConfig read_io_json(const std::string& content, const std::string& file) {
  return read(content, file, ConfigFormat::kJson);
}

IoConfig read_io_config(const std::string& path) {
  std::error_code error;
  require(!std::filesystem::is_directory(path, error), path,
          ": found a folder, expected a configuration (XML or JSON).");
  std::ifstream stream(path, std::ios::binary);
  const std::string content{std::istreambuf_iterator<char>(stream), {}};
  require(stream.is_open() && !content.empty(), path,
          ": found no such file, or an empty one, expected a configuration (XML or JSON).");
  const auto first = content.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  const bool xml = first != std::string::npos && content[first] == '<';
  return xml ? read_io_xml(content, path) : read_io_json(content, path);
}

}  // namespace veridyn::dvrk
