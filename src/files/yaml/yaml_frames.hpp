#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/model/model.hpp"
#include "files/yaml/yaml_node.hpp"

namespace veridyn {

DhConvention read_convention(const YamlNode& node);

/// Reads `frames:`, parents before children.
///
/// @param convention  convention of the file for DH rows that do not name their own; nullopt: none.
std::vector<Frame> read_frames(const YamlNode& list, const std::vector<std::string>& coordinates,
                               const std::optional<DhConvention>& convention);

}  // namespace veridyn
