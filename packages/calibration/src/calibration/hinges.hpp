#pragma once

#include <string>
#include <vector>

#include "rigid_bodies.hpp"
#include "veridyn/calibration/axes.hpp"

namespace veridyn::internal {

/// Bodies joined by hinges, root first; -1 stands for the frame of the cameras.
struct Hinge {
  int a = -1, b = 0;  ///< bodies; a is nearer to the root
  CommonAxis axis;    ///< computed from the relative poses
};

struct HingeTree {
  int root = -1;
  bool root_rests = true;
  std::vector<int> bodies;    ///< bodies of the tree, parents first; without -1
  std::vector<Hinge> hinges;  ///< parents first
  std::vector<Hinge> closing; ///< requested hinges between bodies that the tree joins already
};

/// Finds bodies that turn about a common axis, joined to trees. Requested or neighbouring pairs
/// without an axis are listed in `cannot_tell`.
std::vector<HingeTree> find_hinge_trees(const std::vector<RigidBody>& bodies, const AxesOptions& options,
                                   std::vector<std::string>& cannot_tell);

}  // namespace veridyn::internal
