#pragma once


#include "veridyn/model/model.hpp"

namespace veridyn {

/// Gives every effect's missing parameters a default size: together they cause kSensibleShare (10 %) of the rms
/// effort along the effect's axis, each an equal part, over a standard motion that depends on the arm alone.
///
/// An effect then has the same size in every recording of an arm, whatever its trajectory. The
/// effort is that of the bodies and of the effects that have values. Parameters whose columns
/// vanish over the standard motion become zero. @throws InvalidInput  a body has no values.
constexpr double kSensibleShare = 0.1;
/// @param least_effort  [N m] or [N] lower bound of the effort.
Model with_sensible_effects(const Model& arm, double least_effort = 0.0);

/// The rms effort of every joint over the standard motion, (n) [N m] or [N].
VectorXd standard_effort(const Model& arm);

}  // namespace veridyn
