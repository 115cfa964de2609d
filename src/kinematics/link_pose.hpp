#pragma once

#include "veridyn/kinematics/recursion.hpp"
#include "veridyn/kinematics/tree.hpp"

namespace veridyn {

/// T_world_link, after a forward_pass().
inline Posed link_pose(const Tree& tree, const Workspace<double>& r, int link) {
  Posed T = identity_pose();
  for (int k = link; k >= 0; k = tree.links[k].parent) {
    const Link& at = tree.links[k];
    const LinkState<double>& joint = r.link[k];
    Posed J = identity_pose();
    if (at.type == JointType::kRevolute)
      J.R = {{joint.cosine, -joint.sine, 0}, {joint.sine, joint.cosine, 0}, {0, 0, 1}};
    if (at.type == JointType::kPrismatic) J.p.z = joint.s;
    T = at.A * J * at.B * T;
  }
  return T;
}

}  // namespace veridyn
