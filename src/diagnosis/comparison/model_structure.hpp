#pragma once

#include <string>
#include <vector>

#include "veridyn/diagnosis/model_comparison.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Differences of effects, shapes, constants, gravity, drive gains and known values, and bodies on fixed frames that only
/// one of the models has, as a load that a diagnosis added.
/// @throws InvalidInput  coordinates, moving frames or bodies differ: the models describe two different robots.
std::vector<StructureDifference> structure_differences(const Model& before, const Model& after);

/// Linear combinations w' phi of one model's standard parameters as combinations of another's,
///
///   w_to = M w_from
///
/// Effects of one kind on one axis correspond in the order of their shape constants. A body that only `to` has is
/// fixed to one that both have: phi_to and X phi add to that body's parameters, X by the pose of the one in the other, so
/// that its entries are X' times those of the body that carries it. Entries of a body that only `from` has follow in the
/// same way from others and are left out.
struct Correspondence {
  Correspondence(const Model& from, const Model& to);

  MatrixXd M;        ///< (standard of to x standard of from)
  VectorXd own;      ///< (standard of from) 1: of a body that only `from` has
  /// (standard of from) 1: without counterpart, since frames or effects differ, or a constant by more than half.
  VectorXd foreign;
};

}  // namespace veridyn
