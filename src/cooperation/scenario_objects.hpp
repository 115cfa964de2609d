#pragma once

#include "scenario_parts.hpp"

namespace veridyn {

// What lies between arms, as a scenario file has it; each fails as YamlNode does.

ScenarioMember read_member(const YamlNode& node, const Names& arms);
ScenarioWall read_wall(const YamlNode& node, const Names& arms);
ScenarioBody read_body(const YamlNode& node, const Names& arms);

}  // namespace veridyn
