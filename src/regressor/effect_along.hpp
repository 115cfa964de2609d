#pragma once

#include <vector>

#include "veridyn/dynamics/regressor_batch.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/motion_samples.hpp"

namespace veridyn {

/// A motion that somebody else owns: rows in order of time.
struct MotionView {
  const VectorXd& time;  ///< (rows) [s]
  const MatrixXd& q;     ///< (rows x n) [rad], [m]
  const MatrixXd& dq;
  const MatrixXd& ddq;

  MotionView(const VectorXd& time_, const MatrixXd& q_, const MatrixXd& dq_, const MatrixXd& ddq_)
      : time(time_), q(q_), dq(dq_), ddq(ddq_) {}
  MotionView(const MotionSamples& m)  // NOLINT(google-explicit-constructor)
      : time(m.time), q(m.q), dq(m.dq), ddq(m.ddq) {}
  Eigen::Index rows() const { return q.rows(); }
};

/// Load of the effects along a motion: the torques of the rigid bodies with the arm's own values,
///
///   load = M(q) ddq + C(q, dq) dq + g(q)        (rows x n)
///
/// Zero where a body has no values. Where the accelerations are measured, whoever asks smooths the
/// load by kLoadCutoffShare of the filter's cut-off: it carries their noise, as the inertias' own
/// columns do, and an effect that differentiates it would cancel that noise and look like a cause.
/// The motion itself lies lower. Every room that has a motion means this by load; a controller,
/// which has no accelerations, leaves M ddq out.
MatrixXd rigid_load(const Model& arm, const RegressorBatch& bodies, const MotionView& motion);
constexpr double kLoadCutoffShare = 0.5;

/// The effort along an axis that does the same work as joint torques, one entry per row: least
/// squares of c f = tau.
VectorXd effort_along(const Axis& axis, const MatrixXd& tau);

/// The samples of an effect's axis along a motion.
/// @param load   as rigid_load(), (rows x n); empty: zero.
/// @param start  [s] what the effect counts time from.
std::vector<AxisSample> axis_samples(const BoundEffect& effect, const MotionView& motion,
                                     const MatrixXd& load, double start);

/// The columns of an effect along a motion, (rows x parameters) per unit of the axis; a memory
/// starts fresh. Multiply by the axis' coefficients for the joints.
MatrixXd columns_along(const BoundEffect& effect, const MotionView& motion, const MatrixXd& load,
                       double start);

}  // namespace veridyn
