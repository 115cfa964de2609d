#pragma once

#include <vector>

#include "veridyn/kinematics/links.hpp"

namespace veridyn {

class Model;

/// Kinematic tree and bodies of an arm in the array layout that the recursions read.
struct Tree {
  enum class Keep {
    kEveryFrame,   ///< every frame is a link: for poses
    kBodiesOnly,   ///< frames that neither move nor carry a body are folded into their children
    kMovingLinks,  ///< moving frames alone, each in the frame of its joint: B is the identity, and
                   ///< bodies and frames keep their own poses on these links: for dynamics
  };
  explicit Tree(const Model& arm, Keep keep = Keep::kBodiesOnly);

  /// A tree without a Model, to be filled by add_link() and add_body(): header-only.
  Tree(int coordinates, const Vec3d& gravity_world)
      : joints(coordinates),
        gravity(gravity_world),
        seed_width((coordinates + 7) / 8 * 8) {}

  /// A link on `parent` (-1: the world) with T_parent_link = A * J(s) * B and s = sum of `terms` +
  /// offset. @returns its index.
  int add_link(int parent, JointType type, const std::vector<JointCoefficient>& terms,
               double offset, const Posed& A, const Posed& B = identity_pose());

  /// Adds a body to a link (-1: the world); bodies are numbered in the order of phi.
  void add_body(int link, const Posed& T_link_body = identity_pose()) {
    int next = -1;
    if (link >= 0) {
      int& last = links[link].body;
      next = last;
      last = static_cast<int>(bodies.size());
    }
    bodies.push_back({link, is_identity(T_link_body), T_link_body, next});
  }

  operator Links() const {  // NOLINT: a view, valid while the tree is
    return {joints,
            static_cast<int>(links.size()),
            static_cast<int>(supports.size()),
            static_cast<int>(bodies.size()),
            links.data(),
            coefficients.data(),
            supports.data(),
            bodies.data(),
            gravity,
            seeds.data(),
            seed_width,
            independent && links.size() == static_cast<std::size_t>(joints),
            in_order && independent && links.size() == static_cast<std::size_t>(joints),
            strangers.data(),
            static_cast<int>(strangers.size())};
  }

  static bool is_identity(const Posed& T) {
    return T.p.x == 0 && T.p.y == 0 && T.p.z == 0 && T.R.row0.x == 1 && T.R.row1.y == 1 &&
           T.R.row2.z == 1;
  }

  int joints = 0;
  std::vector<Link> links;
  std::vector<JointCoefficient> coefficients;
  std::vector<SupportingCoordinate> supports;
  std::vector<BodyPlace> bodies;   ///< pose of each body on its link, in the model's order
  std::vector<BodyPlace> frames;   ///< pose of each frame of the model on its link
  std::vector<int> body_links;     ///< link of each body
  std::vector<int> link_of_frame;  ///< link of each frame; -1: the frame is folded away
  Vec3d gravity{0, 0, 0};
  std::vector<double> seeds;
  int seed_width = 0;
  std::vector<LinkPair> strangers;
  bool independent = true;  ///< true as long as no coordinate moves two links and every link follows exactly one
  bool in_order = true;     ///< true as long as coordinate k alone moves link k
};

inline int Tree::add_link(int parent, JointType type, const std::vector<JointCoefficient>& terms,
                          double offset, const Posed& A, const Posed& B) {
  const int k = static_cast<int>(links.size());
  Link link{};
  link.frame = -1;
  link.parent = parent;
  link.body = -1;
  link.type = type;
  link.A_moves = A.p.x != 0 || A.p.y != 0 || A.p.z != 0;
  link.B_is_identity = is_identity(B);
  link.quarter_turn = A.R.row0.x == 1 && A.R.row1.y == 0 && A.R.row1.x == 0 && A.R.row2.x == 0;
  link.A = A;
  link.B = B;
  link.offset = offset;
  link.first_coefficient = static_cast<int>(coefficients.size());
  link.first_support = static_cast<int>(supports.size());
  seeds.resize(seeds.size() + static_cast<std::size_t>(seed_width), 0.0);
  double* seed = seeds.data() + seeds.size() - static_cast<std::size_t>(seed_width);
  for (int i = 0; i < joints; ++i) {
    double own = 0.0;
    for (const JointCoefficient& c : terms) own += c.coordinate == i ? c.coefficient : 0.0;
    if (type == JointType::kFixed) own = 0.0;
    int above = -1;
    if (parent >= 0) {
      const Link& up = links[parent];
      for (int m = up.first_support; m < up.end_support; ++m) {
        if (supports[m].coordinate == i) above = m;
      }
    }
    if (own == 0.0 && above < 0) continue;
    supports.push_back({i, above, own});
    if (own == 0.0) continue;
    for (const JointCoefficient& c : coefficients) independent = independent && c.coordinate != i;
    coefficients.push_back({i, own});
    seed[i] = own;
    in_order = in_order && i == k;
  }
  link.end_coefficient = static_cast<int>(coefficients.size());
  link.end_support = static_cast<int>(supports.size());
  independent = independent && link.end_coefficient == link.first_coefficient + 1;
  if (parent >= 0 && parent != k - 1) links[parent].forks = true;
  int above = parent;
  for (int j = k - 1; j >= 0; --j) {
    if (j == above) {
      above = links[j].parent;
    } else {
      strangers.push_back({j, k});
    }
  }
  links.push_back(link);
  return k;
}

}  // namespace veridyn
