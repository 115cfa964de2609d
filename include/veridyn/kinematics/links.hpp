#pragma once

#include "veridyn/math/vector3.hpp"

// A tree as the recursions read it: plain arrays and nothing that brings inline functions of its
// own. Kernels for several instruction sets are compiled against this, and must not share code with
// the rest of the program.

namespace veridyn {

enum class Motion { kNone, kTurns, kSlides };

/// One term of a joint variable s = c . q + s0.
struct Share {
  int coordinate;
  double coefficient;
};

/// One coordinate that moves a link: one column of the link's Jacobian.
struct Mover {
  int coordinate;
  int above;     ///< index of the same coordinate among the movers of the parent link, or -1
  double share;  ///< coefficient in the link's own joint variable, or 0
};

/// T_parent_link = A * J(s) * B, where J turns about z or slides along z.
struct Link {
  int frame;   ///< index in the model
  int parent;  ///< index of the link it hangs on; -1: the world
  int body;    ///< index of its body, or -1
  Motion motion;
  bool A_is_identity;
  bool B_is_identity;
  Posed A;        ///< T_parent_joint
  Posed B;        ///< T_joint_link
  double offset;  ///< s0
  int first_share, end_share;
  int first_mover, end_mover;  ///< in ascending order of coordinates
};

/// Parents before children. The arrays belong to a Tree.
struct Links {
  int joints;
  int count;   ///< links
  int movers;  ///< Number of all links' entries together
  const Link* link;
  const Share* share;
  const Mover* mover;
  Vec3d gravity;
};

}  // namespace veridyn
