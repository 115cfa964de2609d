#pragma once

#include <optional>

#include "veridyn/model/model.hpp"
#include "files/yaml/yaml_node.hpp"

namespace veridyn {

/// Reads `body: true | false | {mass, com, inertia | parameters, std, fixed, box}`.
std::optional<Body> read_body(const YamlNode& node);

/// Reads `box: {mass_max, com_reach}`.
ParameterBox read_box(const YamlNode& node);

/// Names of the ten numbers, in the order of InertialParameters.
const std::vector<std::string>& inertial_parameter_names();

}  // namespace veridyn
