#pragma once

#include "veridyn/math/vector3.hpp"
#include "veridyn/model/joint_type.hpp"

// The kinematic tree as plain arrays, without inline functions. Kernels are compiled against this
// header once for each instruction set; an inline function that they shared with the rest of the
// program could be linked in a version that the processor does not have.

namespace veridyn {

/// One term of a joint variable s = c . q + s0.
struct JointCoefficient {
  int coordinate;
  double coefficient;
};

/// One coordinate that moves a link: one column of the link's Jacobian.
struct SupportingCoordinate {
  int coordinate;
  int parent_entry;    ///< index of the same coordinate among those of the parent link, or -1
  double coefficient;  ///< coefficient of the coordinate in the link's own joint variable, or 0
};

/// T_parent_link = A * J(s) * B, where J turns about z or slides along z.
struct Link {
  int frame;   ///< index in the model; -1: none
  int parent;  ///< index of the parent link; -1: the world
  int body;    ///< index of the first body on this link, or -1; BodyPlace::next leads to the others
  JointType type;
  bool A_moves;  ///< false: the joint's origin coincides with the parent's
  bool B_is_identity;
  bool forks;  ///< true: some child of the link is not the next link
  bool quarter_turn;  ///< A turns about x by exactly +-90 degrees, as most axes of most arms do
  Posed A;        ///< T_parent_joint
  Posed B;        ///< T_joint_link
  double offset;  ///< s0
  int first_coefficient, end_coefficient;
  int first_support, end_support;  ///< range of its supporting coordinates, which ascend
};

/// The pose of a body or of a frame on a link.
struct BodyPlace {
  int link;  ///< -1: the world
  bool is_identity;
  Posed T_link_body;
  int next;  ///< index of another body on the same link, or -1
};

struct LinkPair {
  int first, second;
};

/// The links of an arm, parents before children. The arrays belong to a Tree.
struct Links {
  int joints;
  int count;     ///< links
  int supports;  ///< sum over the links of their supporting coordinates
  int bodies;
  const Link* link;
  const JointCoefficient* coefficient;
  const SupportingCoordinate* support;
  const BodyPlace* body;
  Vec3d gravity;
  /// Coefficients of all coordinates in a link's joint variable: `seed_width` entries per link, a
  /// whole number of the widest vectors.
  const double* seeds;
  int seed_width;
  /// True: every link has a coordinate of its own and every coordinate a link, so that joint variables are
  /// independent and the mass matrix can be factored along the tree.
  bool independent;
  bool in_order;  ///< true: in addition, coordinate k is the joint variable of link k, up to a coefficient
  const LinkPair* stranger;  ///< pairs of links of which none carries the other
  int strangers;
};

}  // namespace veridyn
