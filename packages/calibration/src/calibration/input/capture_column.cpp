#include <algorithm>
#include <array>
#include <cctype>
#include <string>

#include "veridyn/files/words.hpp"
#include "capture_table.hpp"

namespace veridyn::internal {
namespace {

// The name without "[mm]" or "(mm)" at its end, which goes to `unit`.
std::string split_off_unit(const std::string& name, std::string& unit) {
  const char closing = name.empty() ? ' ' : name.back();
  if (closing != ']' && closing != ')') return name;
  const std::size_t open = name.rfind(closing == ']' ? '[' : '(');
  if (open == std::string::npos) return name;
  unit = name.substr(open + 1, name.size() - open - 2);
  const std::size_t last = name.find_last_not_of(" \t_", open == 0 ? 0 : open - 1);
  return name.substr(0, last == std::string::npos ? 0 : last + 1);
}

// Index of a component in the order x y z qw qx qy qz rx ry rz; -1: another word.
int component_index(const std::string& word) {
  static const std::array<const char*, 10> kComponents = {"x", "y", "z", "qw", "qx", "qy", "qz", "rx", "ry", "rz"};
  const auto* const found = std::find(kComponents.begin(), kComponents.end(), to_lower(word));
  return found == kComponents.end() ? -1 : static_cast<int>(found - kComponents.begin());
}

// BODY/MARKER with '/' in place of other separators.
std::string with_slashes(std::string name) {
  for (const char other : {':', '.'}) {
    if (name.find('/') != std::string::npos) break;
    std::replace(name.begin(), name.end(), other, '/');
  }
  return name;
}

bool is_one_of(const std::string& word, const std::vector<const char*>& words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

}  // namespace

double metres_of(std::string unit) {
  unit = to_lower(unit);
  if (is_one_of(unit, {"m", "meter", "metre", "meters", "metres"})) return 1.0;
  if (is_one_of(unit, {"cm", "centimeter", "centimetre", "centimeters", "centimetres"}))
    return 0.01;
  if (is_one_of(unit, {"mm", "millimeter", "millimetre", "millimeters", "millimetres"}))
    return 0.001;
  return 0.0;
}

CaptureColumn parsed_column(const std::string& name) {
  using Kind = CaptureColumn::Kind;
  CaptureColumn column;
  column.name = name;
  const std::string bare = split_off_unit(name, column.unit);
  const std::string word = to_lower(bare);
  if (is_one_of(word, {"t", "time", "timestamp", "time_s", "seconds"})) {
    column.kind = Kind::kTime;
    return column;
  }
  if (is_one_of(word, {"body", "rigid_body", "rigidbody", "segment", "subject"})) {
    column.kind = Kind::kBodyName;
    return column;
  }
  if (is_one_of(word, {"marker", "marker_name", "name", "label", "point"})) {
    column.kind = Kind::kObjectName;
    return column;
  }
  if (word.size() > 1 && word.size() < 5 && word[0] == 'q' &&
      word.find_first_not_of("0123456789", 1) == std::string::npos) {
    column.kind = Kind::kJoint;
    column.index = std::stoi(word.substr(1)) - 1;
    return column;
  }
  const std::size_t cut = bare.find_last_of("/:. \t_");
  const int whole = component_index(bare);
  const int last = cut == std::string::npos ? whole : component_index(bare.substr(cut + 1));
  if (whole < 0 && last < 0) return column;
  column.kind = Kind::kComponent;
  column.index = whole >= 0 ? whole : last;
  if (whole < 0) column.object = with_slashes(bare.substr(0, cut));
  return column;
}

}  // namespace veridyn::internal
