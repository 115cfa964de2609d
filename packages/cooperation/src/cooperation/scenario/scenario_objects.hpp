#pragma once

#include "cooperation/scenario/scenario_parts.hpp"

namespace veridyn {

// Readers of the objects between arms; errors are those of YamlNode.

ScenarioMember read_member(const YamlNode& node, const Names& arms);
ScenarioWall read_wall(const YamlNode& node, const Names& arms);
ScenarioBody read_body(const YamlNode& node, const Names& arms);

}  // namespace veridyn
