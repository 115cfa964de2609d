#pragma once

#include <vector>

#include "veridyn/kinematics/links.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// What the recursions need of a model, laid out for them: frames that neither move nor carry a
/// body are folded into their children.
struct Tree {
  /// Every frame as a link (for poses), or only what the dynamics need.
  enum class Keep { kEveryFrame, kBodiesOnly };
  explicit Tree(const Model& arm, Keep keep = Keep::kBodiesOnly);

  operator Links() const;  // NOLINT: a view, valid while the tree is

  int joints = 0;
  std::vector<Link> links;
  std::vector<Share> shares;
  std::vector<Mover> movers;
  std::vector<int> body_links;     ///< link of each body, in the model's order
  std::vector<int> link_of_frame;  ///< -1 where folded away
  Vec3d gravity{0, 0, 0};
};

}  // namespace veridyn
