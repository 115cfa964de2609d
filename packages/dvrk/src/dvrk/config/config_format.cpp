#include <algorithm>
#include <array>
#include <cctype>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <utility>
#include <vector>

#include "config_tree.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/math/text_stream.hpp"

namespace veridyn::dvrk {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::pair<const char*, const char*>, 48> kNames{{
    {"Robot", "robots"},
    {"Name", "name"},
    {"HardwareVersion", "hardware_version"},
    {"NumOfActuator", "number_of_actuators"},
    {"SN", "serial_number"},
    {"BoardSerials", "board_serials"},
    {"OnlyIO", "only_IO"},
    {"HasEncoderPreload", "has_encoder_preload"},
    {"Actuator", "actuators"},
    {"ActuatorID", "index"},
    {"BoardID", "board_id"},
    {"AxisID", "axis_id"},
    {"JointType", "joint_type"},
    {"Drive", "drive"},
    {"AmpsToBits", "current_to_bits"},
    {"BitsToFeedbackAmps", "bits_to_current"},
    {"NmToAmps", "effort_to_current"},
    {"MaxCurrent", "maximum_current"},
    {"Encoder", "encoder"},
    {"VelocitySource", "velocity_source"},
    {"BitsToPosSI", "bits_to_position"},
    {"PositionLimitsSoft", "position_limits_soft"},
    {"AnalogIn", "potentiometer"},
    {"BitsToVolts", "bits_to_voltage"},
    {"VoltsToPosSI", "voltage_to_position"},
    {"AnalogBrake", "brakes"},
    {"ReleaseCurrent", "release_current"},
    {"ReleaseTime", "release_time"},
    {"ReleasedCurrent", "released_current"},
    {"EngagedCurrent", "engaged_current"},
    {"Potentiometers", "potentiometers"},
    {"LookupTable", "lookup_table"},
    {"JointToActuatorPosition", "joint_to_actuator_position"},
    {"Tolerance", "tolerances"},
    {"Axis", "axis"},
    {"Distance", "distance"},
    {"Latency", "latency"},
    {"DigitalIn", "digital_inputs"},
    {"BitID", "bit_id"},
    {"DebounceClick", "debounce_click"},
    {"SkipFirstRun", "skip_first_run"},
    {"DigitalOut", "digital_outputs"},
    {"HighDuration", "high_duration"},
    {"LowDuration", "low_duration"},
    {"DallasChip", "dallas_chips"},
    {"Frequency", "frequency"},
    {"Trigger", "trigger"},
    {"Debounce", "debounce"},
}};
// Alternative names that are read and never written: those of the data structures behind the JSON.
constexpr std::array<std::pair<const char*, const char*>, 4> kOtherNames{{
    {"Pressed", "pressed_value"},
    {"Debounce", "debounce_threshold"},
    {"DebounceClick", "debounce_threshold_click"},
    {"AnalogBrake", "brake"},
}};
constexpr std::array<std::pair<const char*, const char*>, 8> kShortNames{{
    {"Scale", "scale"},
    {"Offset", "offset"},
    {"Unit", "unit"},
    {"Lower", "lower"},
    {"Upper", "upper"},
    {"Value", "value"},
    {"Pressed", "pressed"},
    {"Row", "rows"},
}};

// Finds the line of a character. The content is scanned once, since every element needs its line.
class Lines {
 public:
  explicit Lines(const std::string& content) {
    for (std::size_t k = 0; k < content.size(); ++k)
      if (content[k] == '\n') ends_.push_back(static_cast<std::ptrdiff_t>(k));
  }
  // Line number, from 1.
  int of(std::ptrdiff_t offset) const {
    return 1 + static_cast<int>(std::lower_bound(ends_.begin(), ends_.end(), offset) - ends_.begin());
  }

 private:
  std::vector<std::ptrdiff_t> ends_;
};

// No configuration is nested deeper than a few levels; a deeper file would overflow the stack.
constexpr int kDeepest = 30;

void require_depth(int depth, const std::string& file) {
  require(depth < kDeepest, file, ": found elements nested ", depth,
          " deep, expected a configuration.");
}

// Tree of an XML element; throws InvalidInput if it is nested deeper than 30.
ConfigTree tree_of(const pugi::xml_node& node, const Lines& lines, const std::string& file, int depth = 0) {
  require_depth(depth, file);
  ConfigTree tree;
  tree.name = tree.written = node.name();
  tree.line = lines.of(node.offset_debug());
  for (const pugi::xml_attribute& attribute : node.attributes()) {
    ConfigTree& member = tree.members.emplace_back();
    member.name = member.written = attribute.name();
    member.line = tree.line;
    member.scalar = true;
    member.text = attribute.value();
  }
  for (const pugi::xml_node& child : node.children()) {
    if (child.type() == pugi::node_element)
      tree.members.push_back(tree_of(child, lines, file, depth + 1));
  }
  return tree;
}

ConfigTree tree_of(const std::string& name, const Json& value, const std::string& file,
                   int depth = 0) {
  require_depth(depth, file);
  ConfigTree tree;
  tree.written = name;
  tree.name = xml_name(name);
  if (!value.is_object()) {
    tree.scalar = true;
    tree.quoted = value.is_string();
    tree.text = value.is_string() ? value.get<std::string>() : value.dump();
    return tree;
  }
  for (const auto& [key, member] : value.items()) {
    if (member.is_array() && member.empty()) continue;  // no items
    const bool list_of_members = member.is_array() && !member[0].is_number();
    if (!list_of_members) {
      tree.members.push_back(tree_of(key, member, file, depth + 1));
      continue;
    }
    for (const Json& item : member) {
      tree.members.push_back(tree_of(key, item, file, depth + 1));
      tree.members.back().listed = true;
    }
  }
  return tree;
}

ConfigTree parse_xml(const std::string& content, const std::string& file) {
  pugi::xml_document document;
  const pugi::xml_parse_result result = document.load_buffer(content.data(), content.size());
  const Lines lines(content);
  require(static_cast<bool>(result), file, ":", lines.of(result.offset),
          ": found text that is not XML (", result.description(), "), expected XML.");
  return tree_of(document.document_element(), lines, file);
}

constexpr std::size_t kShown = 20;  // characters of the found text in messages

// "file:line:column" of a character.
std::string position_text(const std::string& content, std::size_t at, const std::string& file) {
  const auto end = content.begin() + static_cast<std::ptrdiff_t>(std::min(at, content.size()));
  const auto line = std::count(content.begin(), end, '\n');
  const std::size_t start = at > 0 ? content.rfind('\n', at - 1) : std::string::npos;
  return text(file, ":", 1 + line, ":", start == std::string::npos ? at + 1 : at - start);
}

bool is_name_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '+' || c == '-' ||
         c == '_';
}

// Start of the word that contains a character.
std::size_t word_start(const std::string& content, std::size_t at) {
  while (at > 0 && is_name_character(content[at]) && is_name_character(content[at - 1])) --at;
  return at;
}

// The text at a position: a whole word, or one character.
std::string word_at(const std::string& content, std::size_t at) {
  std::size_t end = at;
  while (end < content.size() && is_name_character(content[end]) && end - at < kShown) ++end;
  if (end > at) return "'" + content.substr(at, end - at) + "'";
  const auto c = static_cast<unsigned char>(content[at]);
  if (c == '\n') return "the end of the line";
  if (c < 0x20) return "a control character";
  return c < 0x80 ? text("'", content[at], "'") : "a character that is not UTF-8";
}

// @param read  characters that were read up to and including the wrong one.
[[noreturn]] void fail_at(const std::string& content, std::size_t read, const std::string& file) {
  if (content.find_first_not_of(" \t\r\n") == std::string::npos)
    throw InvalidInput(text(file, ":1:1: found nothing, expected JSON."));
  if (read > content.size())
    throw InvalidInput(text(position_text(content, content.size(), file),
                            ": found the end of the file, expected the JSON to go on."));
  const std::size_t at = word_start(content, std::max<std::size_t>(read, 1) - 1);
  throw InvalidInput(text(position_text(content, at, file), ": found ", word_at(content, at),
                          ", expected JSON, which has nothing like it there."));
}

// Comments are allowed, since JSON files of the dVRK begin with one for editors.
Json parse_json_text(const std::string& content, const std::string& file) {
  try {
    return Json::parse(content, nullptr, true, true);
  } catch (const Json::parse_error& error) {
    fail_at(content, error.byte, file);
  } catch (const Json::exception&) {
    // Well-formed, but a number is too large for a double.
    throw InvalidInput(text(file, ": found a number too large to hold, expected finite ones."));
  }
}

ConfigTree parse_json(const std::string& content, const std::string& file) {
  return tree_of("", parse_json_text(content, file), file);
}

void write_xml(const ConfigTree& tree, pugi::xml_node parent) {
  pugi::xml_node node = parent.append_child(tree.name.c_str());
  for (const ConfigTree& member : tree.members) {
    if (member.scalar)
      node.append_attribute(member.name.c_str()) = member.text.c_str();
    else
      write_xml(member, node);
  }
}

Json json_of(const ConfigTree& tree) {
  if (tree.scalar) return tree.quoted ? Json(tree.text) : Json::parse(tree.text);
  // <MaxCurrent Value="1"/> is "maximum_current": 1.
  if (tree.members.size() == 1 && tree.members[0].name == "Value") return json_of(tree.members[0]);
  Json object = Json::object();
  for (const ConfigTree& member : tree.members) {
    const std::string name = json_name(member.name);
    if (member.listed)
      object[name].push_back(json_of(member));
    else
      object[name] = json_of(member);
  }
  return object;
}

}  // namespace

std::string json_name(const std::string& xml_name) {
  for (const auto& [xml, json] : kNames)
    if (xml_name == xml) return json;
  for (const auto& [xml, json] : kShortNames)
    if (xml_name == xml) return json;
  return xml_name;
}

std::string xml_name(const std::string& json_name) {
  for (const auto& [xml, json] : kNames)
    if (json_name == json) return xml;
  for (const auto& [xml, json] : kShortNames)
    if (json_name == json) return xml;
  for (const auto& [xml, json] : kOtherNames)
    if (json_name == json) return xml;
  return json_name;
}

ConfigTree parse_config(const std::string& content, const std::string& file, ConfigFormat format) {
  return format == ConfigFormat::kXml ? parse_xml(content, file) : parse_json(content, file);
}

std::string print_config(const ConfigTree& tree, ConfigFormat format) {
  if (format == ConfigFormat::kJson) return json_of(tree).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "utf-8";
  write_xml(tree, document);
  TextStream out;
  document.save(out, "  ");
  return out.str();
}

}  // namespace veridyn::dvrk
