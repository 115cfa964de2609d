#include "files/yaml/yaml_axis.hpp"

#include "model/suggestion.hpp"

namespace veridyn {

int index_of(const std::vector<std::string>& names, const std::string& name) {
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (names[k] == name) return static_cast<int>(k);
  }
  return -1;
}

Axis read_axis(const YamlNode& node, const std::vector<std::string>& coordinates) {
  Axis axis{VectorXd::Zero(coordinates.size()), 0.0};
  const std::string expected = "{coordinate: coefficient, ...} over " + listed(coordinates);
  const std::vector<YamlNode::Entry> entries = node.entries(expected);
  if (entries.empty()) node.fail("an empty map", expected);
  for (const YamlNode::Entry& entry : entries) {
    const int i = index_of(coordinates, entry.key);
    if (i < 0) {
      entry.key_node.fail(
          "the unknown coordinate '" + entry.key + "'" + did_you_mean(entry.key, coordinates),
          "one of: " + listed(coordinates));
    }
    axis.coefficients[i] = entry.value.number();
  }
  return axis;
}

}  // namespace veridyn
