#pragma once

#include <vector>

#include "state_links.hpp"
#include "veridyn/kinematics/tree.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

/// A tree with its parameters, laid out for the kernels of single states. Immutable.
class StateModel {
 public:
  /// @param phi  ten of every body; empty where only motion is asked for.
  StateModel(const Tree& tree, const VectorXd& phi);

  /// A view, valid while this object is where it is.
  StateTree view() const;

  /// Doubles of workspace, with what aligning them takes.
  std::size_t workspace() const;

  /// The first of these doubles that is aligned for the widest vectors.
  static double* aligned(std::vector<double>& memory);

 private:
  int coordinates_, joints_, bodies_;
  std::vector<StateLink> links_;
  std::vector<StateShare> shares_;
  std::vector<double> phi_, quads_;
  Vec3d gravity_;
};

}  // namespace veridyn
