#pragma once

#include <string>

#include "veridyn/model/model.hpp"

namespace veridyn_ros {

/// An arm as RViz draws it.
struct Looks {
  std::string urdf;      ///< with a rod from each frame to the next; what slides is as long as it slides out
  veridyn::Model links;  ///< a frame for every link of it, those between two joints included
};

/// @throws veridyn::InvalidInput  as to_urdf().
Looks appearance_of(const veridyn::Model& model);

}  // namespace veridyn_ros
