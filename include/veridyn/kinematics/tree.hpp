#pragma once

#include <vector>

#include "veridyn/math/vector3.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// What the recursions need of a model, laid out for them: frames that neither move nor carry a body are
/// folded into their children.
struct Tree {
  struct Share {
    int coordinate;
    double coefficient;
  };
  struct Link {
    int frame;   ///< index in the model
    int parent;  ///< index of the link it hangs on; -1: the world
    JointType type;
    Posed A;  ///< T_parent_joint
    Posed B;  ///< T_joint_link
    bool A_is_identity;
    bool B_is_identity;
    std::vector<Share> shares;  ///< nonzero entries of c in s = c . q + s0
    double offset;              ///< s0
    std::vector<int> support;   ///< coordinates that move this link, ascending
    int body;                   ///< index of its body, or -1
  };

  /// Every frame as a link (for poses), or only what the dynamics need.
  enum class Keep { kEveryFrame, kBodiesOnly };
  explicit Tree(const Model& arm, Keep keep = Keep::kBodiesOnly);

  int joints = 0;
  std::vector<Link> links;
  std::vector<int> body_links;      ///< link of each body, in the model's order
  std::vector<int> link_of_frame;   ///< -1 where folded away
  Vec3d gravity{0, 0, 0};
};

}  // namespace veridyn
