#include "config_tree.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>

#include "veridyn/files/words.hpp"
#include "veridyn/model/suggestion.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

// The whole text as a finite number, independent of the locale, without surrounding spaces; nullopt for other
// text.
std::optional<double> number_in(const std::string& word) {
  const auto first = word.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return std::nullopt;
  const char* begin = word.data() + first + (word[first] == '+' ? 1 : 0);
  const char* end = word.data() + word.find_last_not_of(" \t\r\n") + 1;
  double value = 0.0;
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

void collect_unused(const ConfigTree& tree, const ConfigSource& source, const std::string& place,
                    std::vector<std::string>& lines) {
  for (const ConfigTree& member : tree.members) {
    const std::string inside = place.empty() ? member.written : place + "/" + member.written;
    if (source.used.count(&member) != 0) {
      collect_unused(member, source, inside, lines);
      continue;
    }
    const std::string line = member.line > 0 ? text(":", member.line) : "";
    lines.push_back(text(source.file, line, ": ", inside, " is not known here and was not used."));
  }
}

}  // namespace

void ConfigNode::fail(const std::string& found, const std::string& expected) const {
  const std::string line = tree_->line > 0 ? text(":", tree_->line) : "";
  const std::string place = place_.empty() ? "" : place_ + ": ";
  throw InvalidInput(
      text(source_->file, line, ": ", place, "found ", found, ", expected ", expected, "."));
}

std::string ConfigNode::display_name(const std::string& name) const {
  return source_->format == ConfigFormat::kJson ? json_name(name) : name;
}

int ConfigNode::count(const std::string& name) const {
  return static_cast<int>(std::count_if(tree_->members.begin(), tree_->members.end(),
                                        [&](const ConfigTree& m) { return m.name == name; }));
}

ConfigNode ConfigNode::child_node(const ConfigTree& tree, int index) const {
  std::string step = tree.written;
  for (const ConfigTree& member : tree.members) {
    if (member.name == "Name" && member.scalar) {
      step += " " + member.text;
      index = -1;
    }
  }
  if (index >= 0) step += text(" ", index);
  return {tree, *source_, place_.empty() ? step : place_ + "/" + step};
}

ConfigNode ConfigNode::at(const std::string& name) const {
  const int found = count(name);
  if (found == 0) {
    std::vector<std::string> there;
    for (const ConfigTree& member : tree_->members) there.push_back(member.written);
    fail("no " + display_name(name) + did_you_mean(display_name(name), there), display_name(name) + " here");
  }
  if (found > 1) fail(text(found, " of ", display_name(name)), "one");
  for (const ConfigTree& member : tree_->members)
    if (member.name == name) return child_node(member, -1);
  return *this;  // not reached
}

std::vector<ConfigNode> ConfigNode::items(const std::string& name) const {
  std::vector<ConfigNode> out;
  for (const ConfigTree& member : tree_->members)
    if (member.name == name) out.push_back(child_node(member, static_cast<int>(out.size())));
  return out;
}

std::string ConfigNode::word() const {
  if (!tree_->scalar) fail("an element", "a value");
  return tree_->text;
}

double ConfigNode::number() const {
  const std::optional<double> value = tree_->scalar ? number_in(tree_->text) : std::nullopt;
  if (!value) fail(tree_->scalar ? "'" + tree_->text + "'" : "an element", "a finite number");
  return *value;
}

std::string ConfigNode::word(const std::string& name, const std::string& fallback) const {
  return has(name) ? word(name) : fallback;
}

double ConfigNode::number(const std::string& name, double fallback) const {
  return has(name) ? number(name) : fallback;
}

double ConfigNode::positive(const std::string& name) const {
  const double value = number(name);
  if (!(value > 0.0)) at(name).fail(text(value), "a positive number");
  return value;
}

double ConfigNode::not_negative(const std::string& name, double fallback) const {
  const double value = number(name, fallback);
  if (!(value >= 0.0)) at(name).fail(text(value), "0 or more");
  return value;
}

double ConfigNode::nonzero(const std::string& name) const {
  const double value = number(name);
  if (value == 0.0) at(name).fail("0", "a number other than 0");
  return value;
}

int ConfigNode::integer_in(const std::string& name, int lower, int upper) const {
  const ConfigNode node = at(name);
  const double value = node.number();
  if (value != std::floor(value) || value < lower || value > upper)
    node.fail(text(value), text("a whole number from ", lower, " to ", upper));
  return static_cast<int>(value);
}

bool ConfigNode::flag(const std::string& name, bool fallback) const {
  return choice(name, {"false", "true", "0", "1"}, fallback ? 1 : 0) % 2 == 1;
}

int ConfigNode::choice(const std::string& name, const std::vector<std::string>& words,
                       int fallback) const {
  if (!has(name)) return fallback;
  const std::string given = word(name);
  for (std::size_t k = 0; k < words.size(); ++k)
    if (to_lower(given) == to_lower(words[k])) return static_cast<int>(k);
  at(name).fail("'" + given + "'", "one of: " + listed(words));
}

double ConfigNode::value(const std::string& name) const {
  const ConfigNode node = at(name);
  const ConfigNode holder = node.tree_->scalar ? node : node.at("Value");
  const double value = holder.number();
  if (value < 0.0) holder.fail(text(value), "0 or more");
  return value;
}

std::vector<std::string> unused(const ConfigTree& tree, const ConfigSource& source) {
  std::vector<std::string> lines;
  collect_unused(tree, source, "", lines);
  return lines;
}

}  // namespace veridyn::dvrk
