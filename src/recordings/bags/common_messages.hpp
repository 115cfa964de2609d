#pragma once

#include <string>

namespace veridyn::bags {

/// The definition of a common ROS type, for files without definitions; null for other types.
const char* common_message(const std::string& type, bool ros2);

}  // namespace veridyn::bags
