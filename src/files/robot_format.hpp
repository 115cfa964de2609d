#pragma once

#include <optional>
#include <string>

namespace veridyn {

enum class RobotFormat { kYaml, kUrdf, kMjcf, kSdf };

/// The format of a robot file by its ending, or, if that is .xml, by its root element (URDF if the file cannot
/// be read); nullopt for other endings.
std::optional<RobotFormat> robot_format(const std::string& path);

}  // namespace veridyn
