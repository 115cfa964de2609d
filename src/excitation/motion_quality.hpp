#pragma once

#include "excitation/base_columns.hpp"
#include "excitation/search/question.hpp"

namespace veridyn {

/// Stores the quality of a motion's samples in the result.
/// @param chosen  base columns of all base parameters.
void evaluate_motion(const Model& arm, const BaseRegressor& chosen, const MotionSamples& motion,
                  const MotionSamples& random, const ExcitationOptions& options, Excitation& out);

/// Condition numbers of the essential parameters alone.
EssentialParameters evaluate_essential(const Model& arm, const EssentialColumns& columns, double share,
                                    const BaseRegressor& chosen, const MotionSamples& motion);

/// Evaluates how well a motion separates two causes. @param gram  Gram matrix of the question's exact columns.
Discrimination evaluate_discrimination(const Question& question, const MatrixXd& gram);

}  // namespace veridyn
