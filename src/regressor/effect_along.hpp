#pragma once

#include <utility>
#include <vector>

#include "veridyn/dynamics/torque_regressor.hpp"
#include "veridyn/effects/effect_facts.hpp"
#include "veridyn/math/motion_samples.hpp"

namespace veridyn {

/// References to a motion owned by the caller: rows in order of time.
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
/// It is zero if a body has no values. With measured accelerations the caller low-passes the load at
/// kLoadCutoffShare of the filter's cut-off, because it has their noise, as the columns of the inertias do: an
/// effect that differentiates the load would otherwise cancel that noise and appear significant. The motion
/// itself has lower frequencies. All code with a motion uses this definition; a controller, which has no
/// accelerations, omits M ddq.
MatrixXd rigid_load(const Model& arm, const TorqueRegressor& bodies, const MotionView& motion);
constexpr double kLoadCutoffShare = 0.5;

/// The effort along an axis that corresponds to joint torques, one entry per row: least squares of
/// c f = tau.
VectorXd effort_along(const Axis& axis, const MatrixXd& tau);

/// The samples of an effect's axis along a motion.
/// @param load   as rigid_load(), (rows x n); empty: zero.
/// @param start  [s] origin of the effect's time.
std::vector<AxisSample> axis_samples(const BoundEffect& effect, const MotionView& motion,
                                     const MatrixXd& load, double start);

/// The columns of an effect along a motion, (rows x parameters) per unit of the axis, with memory
/// initially unloaded. Multiply by the axis' coefficients for the joints.
MatrixXd columns_along(const BoundEffect& effect, const MotionView& motion, const MatrixXd& load,
                       double start);

/// Columns of an effect for samples that arrive in pieces, (rows x parameters); the memory continues from
/// piece to piece.
class ColumnsInPieces {
 public:
  explicit ColumnsInPieces(EffectFacts facts) : facts_(std::move(facts)), effect_(facts_.bound()) {}
  const EffectFacts& facts() const { return facts_; }
  void reset() { effect_.reset(); }
  MatrixXd next(const std::vector<AxisSample>& samples);  ///< (samples x parameters) of the next samples, memories continued

  /// Samples of the effect's axis along a motion, as by axis_samples().
  std::vector<AxisSample> samples(const MotionView& motion, const MatrixXd& load) const {
    return axis_samples(effect_, motion, load, 0.0);
  }

 private:
  EffectFacts facts_;
  BoundEffect effect_;
};

}  // namespace veridyn
