#pragma once

#include "veridyn/math/motion_samples.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// The whole torque of the motors along a motion: rigid bodies and every effect of the model with
/// its values,
///
///   tau = M(q) ddq + C(q, dq) dq + g(q) + effects(t, q, dq, ddq, past)
///
/// Effects with memory start unloaded at the first row, where their time is zero. Between two rows they are
/// evaluated at `substeps` states on quintics through q, dq and ddq; with times that do not increase, or with
/// one substep, at the rows alone.
///
/// @returns (rows x n) [N m], [N] where the joint is prismatic.
/// @throws InvalidInput  a body or an effect has no values; the motion is not (rows x n), or empty.
MatrixXd joint_torques(const Model& arm, const MotionSamples& motion, int substeps = 4);

/// Torques at one state, (n) each: memories are unloaded, time is zero, and effects on the whole arm, which
/// need a motion, are not included.
VectorXd joint_torques(const Model& arm, const VectorRef& q, const VectorRef& dq,
                       const VectorRef& ddq);

}  // namespace veridyn
