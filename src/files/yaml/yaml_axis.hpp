#pragma once

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"
#include "files/yaml/yaml_node.hpp"

namespace veridyn {

/// Position of a name in a list, or -1.
int index_of(const std::vector<std::string>& names, const std::string& name);

/// Reads c . q from {coordinate: coefficient, ...}.
Axis read_axis(const YamlNode& node, const std::vector<std::string>& coordinates);

}  // namespace veridyn
