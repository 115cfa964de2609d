#pragma once

#include <string>

namespace veridyn::cli {

/// True for URDF: a maker's file describes the arms of a series, and its values are no MODEL of this
/// very arm.
inline bool is_makers_file(const std::string& robot) {
  const auto ends_with = [&robot](const std::string& ending) {
    return robot.size() >= ending.size() &&
           robot.compare(robot.size() - ending.size(), ending.size(), ending) == 0;
  };
  return ends_with(".urdf") || ends_with(".xml");
}

}  // namespace veridyn::cli
