#include "recordings/bags/message_plan.hpp"

#include <charconv>
#include <map>
#include <optional>
#include <utility>

#include "recordings/bags/common_messages.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::bags {
namespace {

constexpr int kDeepest = 16;          // largest depth of nested messages
constexpr std::size_t kLeaves = 4096; // largest number of leaves of one type

struct Line {
  std::string type, name;
  FieldNode::Repeat repeat = FieldNode::Repeat::kOne;
  std::uint32_t count = 0;
};

using Definitions = std::map<std::string, std::vector<Line>>;

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") + 1 - first);
}

// Parses a line `type name`, `type[] name`, `type[3] name`, `type[<=9] name default`; constants are
// not part of a message.
std::optional<Line> parse_line(std::string_view text) {
  text = trimmed(text.substr(0, text.find('#')));
  const std::size_t blank = text.find_first_of(" \t");
  if (blank == std::string_view::npos) return std::nullopt;
  std::string_view type = text.substr(0, blank);
  std::string_view rest = trimmed(text.substr(blank));
  const std::size_t end = rest.find_first_of(" \t=");
  if (end != std::string_view::npos && trimmed(rest.substr(end)).substr(0, 1) == "=")
    return std::nullopt;
  Line line;
  line.name = rest.substr(0, end);
  const std::size_t bracket = type.find('[');
  if (bracket != std::string_view::npos) {
    const std::string_view size = type.substr(bracket + 1, type.find(']') - bracket - 1);
    const bool sequence = size.empty() || size[0] == '<';
    line.repeat = sequence ? FieldNode::Repeat::kSequence : FieldNode::Repeat::kFixed;
    if (!sequence) std::from_chars(size.data(), size.data() + size.size(), line.count);
    type = type.substr(0, bracket);
  }
  line.type = type.substr(0, type.find("<="));  // removes the bound of a string: string<=10
  return line;
}

std::string package_of(const std::string& type) {
  return type.substr(0, type.find('/'));
}

// Parses all definitions in a text: the first one is that of `type`.
Definitions parse(const std::string& type, std::string_view text) {
  Definitions out;
  std::vector<Line>* lines = &out[short_type(type)];
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.substr(0, 5) == "=====") {
      lines = nullptr;
    } else if (line.substr(0, 4) == "MSG:") {
      lines = &out[short_type(std::string(trimmed(line.substr(4))))];
      lines->clear();
    } else if (lines != nullptr) {
      if (const std::optional<Line> parsed = parse_line(line)) lines->push_back(*parsed);
    }
  }
  return out;
}

std::optional<FieldKind> primitive(const std::string& type) {
  static const std::map<std::string, FieldKind> kKinds = {
      {"bool", FieldKind::kBool},       {"int8", FieldKind::kInt8},
      {"uint8", FieldKind::kUint8},     {"byte", FieldKind::kUint8},
      {"char", FieldKind::kUint8},      {"int16", FieldKind::kInt16},
      {"uint16", FieldKind::kUint16},   {"int32", FieldKind::kInt32},
      {"uint32", FieldKind::kUint32},   {"int64", FieldKind::kInt64},
      {"uint64", FieldKind::kUint64},   {"float32", FieldKind::kFloat32},
      {"float64", FieldKind::kFloat64}, {"string", FieldKind::kString},
      {"time", FieldKind::kTime},       {"duration", FieldKind::kDuration},
      {"builtin_interfaces/Time", FieldKind::kTime},
      {"builtin_interfaces/Duration", FieldKind::kDuration}};
  const auto found = kKinds.find(type);
  if (found == kKinds.end()) return std::nullopt;
  return found->second;
}

class Planner {
 public:
  Planner(Definitions definitions, bool ros2) : definitions_(std::move(definitions)), ros2_(ros2) {}

  MessagePlan plan(const std::string& type) {
    plan_.fields = fields_of(short_type(type), "", 0);
    return std::move(plan_);
  }

 private:
  const std::vector<Line>& lines_of(const std::string& type) {
    const auto known = definitions_.find(type);
    if (known != definitions_.end() && (!known->second.empty() || common_message(type, ros2_) == nullptr))
      return known->second;
    const char* common = common_message(type, ros2_);
    require(common != nullptr, "found messages of type ", type,
            " without their definition, expected the file to hold it.");
    Definitions parsed = parse(type, common);
    return definitions_[type] = std::move(parsed[type]);
  }

  // The full name of a type that a definition in `package` mentions.
  std::string resolved(const std::string& name, const std::string& package) const {
    const std::string brief = short_type(name);
    if (primitive(brief) || brief.find('/') != std::string::npos) return brief;
    if (brief == "Header") return "std_msgs/Header";
    return package + "/" + brief;
  }

  std::vector<FieldNode> fields_of(const std::string& type, const std::string& path, int depth) {
    require(depth < kDeepest, "found messages nested deeper than ", kDeepest, " in type ", type,
            ", expected fewer.");
    std::vector<FieldNode> nodes;
    const std::vector<Line> lines = lines_of(type);
    for (const Line& line : lines) {
      FieldNode node;
      node.repeat = line.repeat;
      node.count = line.count;
      const std::string inner = resolved(line.type, package_of(type));
      const std::string place = path.empty() ? line.name : path + "/" + line.name;
      if (const auto kind = primitive(inner)) {
        node.kind = *kind;
        node.leaf = static_cast<int>(plan_.paths.size());
        plan_.paths.push_back(place);
        require(plan_.paths.size() < kLeaves, "found more than ", kLeaves, " fields in type ", type,
                ", expected fewer.");
      } else {
        node.children = fields_of(inner, place, depth + 1);
      }
      nodes.push_back(std::move(node));
    }
    return nodes;
  }

  Definitions definitions_;
  bool ros2_;
  MessagePlan plan_;
};

}  // namespace

std::string short_type(const std::string& type) {
  const std::size_t middle = type.find("/msg/");
  return middle == std::string::npos ? type : type.substr(0, middle) + type.substr(middle + 4);
}

MessagePlan plan_of(const std::string& type, const std::string& definition, bool ros2) {
  return Planner(parse(type, definition), ros2).plan(type);
}

}  // namespace veridyn::bags
