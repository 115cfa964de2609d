#pragma once

#include <string>
#include <utility>
#include <vector>

#include "veridyn/files/yaml/yaml_node.hpp"
#include "veridyn/cooperation/scenario.hpp"
#include "veridyn/model/model.hpp"
#include "veridyn/model/suggestion.hpp"
#include "veridyn/simulation/object.hpp"

// Parts of the scenario reader; those that take nodes fail with "file:line:column: found ...,
// expected ...".

namespace veridyn {

/// Names that a file has given, each once.
struct Names {
  std::string what;  ///< "arm"
  std::vector<std::string> all;

  /// Adds a name; fails at `node` if it exists.
  void add(const std::string& name, const YamlNode& node);
  int index(const YamlNode& node) const;  ///< index of the name in the node, from 0; fails if unknown
};

/// @throws InvalidInput  the robot has other joints, limits or frames than the arm is given.
void check_arm(const ScenarioArm& arm, const Model& model);

Eigen::Vector3d read_vector3(const YamlNode& node, const std::string& unit);
/// The number above zero under `key`, or `otherwise` if the key is missing.
double read_positive_or(const YamlNode& node, const std::string& key, double otherwise);
double read_nonnegative_or(const YamlNode& node, const std::string& key, double otherwise);
long read_whole_number(const YamlNode& node);

/// Reads one of several words.
template <typename T>
T read_choice(const YamlNode& node, const std::vector<std::pair<std::string, T>>& choices) {
  std::vector<std::string> names;
  for (const auto& [name, value] : choices) names.push_back(name);
  const std::string word = node.word("one of: " + listed(names));
  for (const auto& [name, value] : choices) {
    if (name == word) return value;
  }
  node.fail(node.found() + did_you_mean(word, names), "one of: " + listed(names));
}

ScenarioPhase read_phase(const YamlNode& node, const Names& arms, const Names& members);
ScenarioFault read_fault(const YamlNode& node, const Names& arms, const Names& members);

}  // namespace veridyn
