#include "files/yaml/yaml_node.hpp"

#include <algorithm>
#include <limits>
#include <set>

#include "model/excerpt.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"

namespace veridyn {
namespace {

std::string quoted(const std::string& name) {
  return "'" + name + "'";
}

std::string position(const std::string& file, const YAML::Mark& mark) {
  return mark.is_null() ? file : text(file, ":", mark.line + 1, ":", mark.column + 1);
}

}  // namespace

YamlNode YamlNode::parse(const std::string& content, YamlSource& source) {
  try {
    return {YAML::Load(content), source, ""};
  } catch (const YAML::Exception& error) {
    throw InvalidInput(text(position(source.file, error.mark), ": found text that is not YAML (",
                            excerpt(error.msg, 200), "), expected ", source.expected, "."));
  }
}

void YamlNode::fail(const std::string& found, const std::string& expected) const {
  throw InvalidInput(
      text(position(source_->file, node_.Mark()), ": found ", excerpt(found, 200), ", expected ", expected, "."));
}

std::string YamlNode::found() const {
  if (node_.IsScalar()) return quoted(excerpt(node_.Scalar()));
  if (node_.IsSequence()) return text("a list of ", node_.size());
  return node_.IsMap() ? "a map" : "nothing";
}

std::string YamlNode::where() const {
  return text(source_->file, ":", node_.Mark().line + 1);
}

std::string YamlNode::word(const std::string& expected) const {
  if (!node_.IsScalar() || node_.Scalar().empty()) fail(found(), expected);
  return node_.Scalar();
}

double YamlNode::number() const {
  const std::string expression = word("a number");
  try {
    const double value = evaluate(expression, source_->constants);
    if (!is_plain_number(expression)) source_->formulas[place_] = expression;
    return value;
  } catch (const InvalidInput& reason) {
    fail(reason.what(), "a finite number or arithmetic over pi and the constants");
  }
}

double YamlNode::positive_number() const {
  const double value = number();
  if (value <= 0.0) fail(found(), "a positive number");
  return value;
}

double YamlNode::number_or_infinity() const {
  if (node_.IsScalar() && node_.Scalar() == ".inf") return std::numeric_limits<double>::infinity();
  if (node_.IsScalar() && node_.Scalar() == "-.inf")
    return -std::numeric_limits<double>::infinity();
  return number();
}

bool YamlNode::flag() const {
  bool value = false;
  if (!node_.IsScalar() || !YAML::convert<bool>::decode(node_, value))
    fail(found(), "true or false");
  return value;
}

std::vector<double> YamlNode::numbers(std::size_t size, const std::string& expected) const {
  const std::vector<YamlNode> all = items(expected);
  if (all.size() != size) fail(found(), expected);
  std::vector<double> values;
  for (const YamlNode& item : all) values.push_back(item.number());
  return values;
}

std::vector<YamlNode> YamlNode::items(const std::string& expected) const {
  if (!node_.IsSequence()) fail(found(), expected);
  std::vector<YamlNode> all;
  for (const YAML::Node& item : node_) {
    all.push_back({item, *source_, text(place_, "/", all.size())});
  }
  return all;
}

std::vector<YamlNode::Entry> YamlNode::entries(const std::string& expected) const {
  if (!node_.IsMap()) fail(found(), expected);
  std::vector<Entry> all;
  std::set<std::string> keys;
  for (const auto& pair : node_) {
    const YamlNode key_node(pair.first, *source_, place_);
    const std::string key = key_node.word("a name");
    if (!keys.insert(key).second) key_node.fail("the key " + quoted(key) + " twice", "each key once");
    all.push_back(
        {key, key_node, {pair.second, *source_, place_.empty() ? key : place_ + "/" + key}});
  }
  return all;
}

void YamlNode::allow_keys(const std::vector<std::string>& keys) const {
  for (const Entry& entry : entries("a map with the keys " + listed(keys))) {
    if (std::find(keys.begin(), keys.end(), entry.key) != keys.end()) continue;
    entry.key_node.fail("the unknown key " + quoted(entry.key) + did_you_mean(entry.key, keys),
                        "one of: " + listed(keys));
  }
}

std::optional<YamlNode> YamlNode::find(const std::string& key) const {
  for (const Entry& entry : entries("a map")) {
    if (entry.key == key) return entry.value;
  }
  return std::nullopt;
}

YamlNode YamlNode::at(const std::string& key) const {
  const std::optional<YamlNode> value = find(key);
  if (!value) fail("no key " + quoted(key), quoted(key) + " here");
  return *value;
}

YamlNode YamlNode::with_path(const std::string& place) const {
  return {node_, *source_, place};
}

}  // namespace veridyn
