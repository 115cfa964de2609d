#pragma once

#include <vector>

#include "veridyn/math/motion_samples.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// A base parameter that hardly any motion can separate from the others.
struct WeakColumn {
  int column;    ///< column of the bodies and effects
  double share;  ///< remainder of the column, of norm one, after those before it
};

/// The base columns that remain when each must add more than `share` of its norm to those chosen
/// before it, at random states within the limits; and the rest of a base, the strongest first.
/// (Essential parameters: Pham and Gautier, IEEE ICRA 1991.)
struct EssentialColumns {
  std::vector<int> kept;
  std::vector<WeakColumn> non_essential;
};
EssentialColumns essential_columns(const Model& arm, double share);

/// An equivalent choice of base columns by single swaps, which decrease the condition number along
/// the motion (columns of norm one).
/// @param base  initial choice.
/// @param gram  of all columns of the arm, along the motion.
std::vector<int> best_conditioned_columns(const std::vector<int>& base, MatrixXd gram);

/// The Gram matrix of all columns of an arm per row of a motion.
MatrixXd gram_of_all_columns(const Model& arm, const MotionSamples& motion);

}  // namespace veridyn
