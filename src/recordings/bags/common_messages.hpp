#pragma once

#include <string>

namespace veridyn::bags {

/// The definition of a common ROS type, for files that keep none; null if it is not among them.
const char* common_message(const std::string& type, bool ros2);

}  // namespace veridyn::bags
