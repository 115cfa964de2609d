#pragma once

#include <string>

#include "veridyn/model/model.hpp"

namespace veridyn_ros {

/// An arm as RViz draws it.
struct Looks {
  std::string urdf;      ///< with a rod from each frame to the next; a rod that slides is as long as its travel
  veridyn::Model links;  ///< a frame for every link of the URDF, also for those between two joints
};

/// URDF and links of a model. @throws veridyn::InvalidInput  as to_urdf().
Looks appearance_of(const veridyn::Model& model);

}  // namespace veridyn_ros
