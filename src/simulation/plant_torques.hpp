#pragma once

#include "veridyn/effects/effect.hpp"
#include "veridyn/math/motion_samples.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Inverse dynamics of an arm with values along a motion: rigid bodies and all effects, (rows x n).
///
/// Effects with memory start unloaded and are evaluated at `substeps` states per row, on quintics through q, dq
/// and ddq.
/// @throws InvalidInput  a body has no values, or an effect is unknown.
MatrixXd plant_torques(const Model& arm, const MotionSamples& motion, int substeps);

/// Torques of the rigid bodies alone, (rows x n). @throws InvalidInput  a body has no values.
MatrixXd rigid_torques(const Model& arm, const MotionSamples& motion);

/// Columns of an effect with one row per row of the motion, (rows x parameters). `rigid` are the torques of the
/// rigid bodies.
MatrixXd term_columns(const Model& arm, const EffectTerm& term, const MotionSamples& motion,
                        const MatrixXd& rigid, int substeps);

/// The sum of the torques of those effects that `wanted` accepts, for given loads (rows x n); (rows x n).
MatrixXd effect_torques(const Model& arm, const MotionSamples& motion, const MatrixXd& load,
                        int substeps, bool (*wanted)(const EffectTerm&));

}  // namespace veridyn
