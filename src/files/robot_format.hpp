#pragma once

#include <optional>
#include <string>

namespace veridyn {

enum class RobotFormat { kYaml, kUrdf, kMjcf, kSdf };

/// Format of a robot file by its ending, and by its root element where it ends in .xml (URDF if
/// that cannot be read); nullopt where the ending is no robot file's.
std::optional<RobotFormat> robot_format(const std::string& path);

}  // namespace veridyn
