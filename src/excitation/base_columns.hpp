#pragma once

#include <vector>

#include "veridyn/math/motion_samples.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// A base parameter that hardly any motion separates from the others.
struct WeakColumn {
  int column;    ///< index among the columns of bodies and effects
  double share;  ///< remainder of the column, of norm one, after projection onto the columns before it
};

/// Essential parameters (Pham and Gautier, IEEE ICRA 1991): the base columns that remain if each must add
/// more than `share` of its norm to those chosen before it, at random states within the limits; and the other
/// base columns, the strongest first.
struct EssentialColumns {
  std::vector<int> kept;
  std::vector<WeakColumn> non_essential;
};
EssentialColumns essential_columns(const Model& arm, double share);

/// Improves a choice of base columns by single swaps that decrease the condition number along the motion
/// (columns of norm one).
/// @param base  initial choice.
/// @param gram  Gram matrix of all columns of the arm, along the motion.
std::vector<int> best_conditioned_columns(const std::vector<int>& base, MatrixXd gram);

/// Gram matrix of all columns of an arm, divided by the number of rows of the motion.
MatrixXd gram_of_all_columns(const Model& arm, const MotionSamples& motion);

}  // namespace veridyn
