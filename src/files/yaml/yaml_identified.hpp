#pragma once

#include <string>

#include "veridyn/model/model.hpp"
#include "files/yaml/yaml_node.hpp"

namespace veridyn {

/// Reads `identified: {recordings, clusters, error, motion, base: [{name, unit, value, free, std, of,
/// factor}]}`; std follows from factor and serves human readers.
IdentifiedBase read_identified(const YamlNode& node, int joints);

/// The section `identified:` as text.
std::string identified_text(const IdentifiedBase& identified);

}  // namespace veridyn
