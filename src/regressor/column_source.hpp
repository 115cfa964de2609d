#pragma once

#include <memory>
#include <vector>

#include "veridyn/dynamics/torque_regressor.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/motion_samples.hpp"

namespace veridyn {

/// Columns of a regressor along a motion, and their derivatives with respect to it. Immutable: one object
/// serves several threads.
class ColumnSource {
 public:
  virtual ~ColumnSource() = default;

  /// Number of columns.
  virtual int count() const = 0;

  /// True if a row depends on the rows before it.
  virtual bool has_memory() const { return false; }

  /// Columns that can differ from zero in the rows of a joint, ascending.
  virtual std::vector<int> columns(int joint) const = 0;

  /// Y[i](row, c): entry of column columns(i)[c] in joint i's row; sized here.
  virtual void evaluate(const MotionSamples& motion, std::vector<MatrixXd>& Y) const = 0;

  /// Adds the derivatives of sum_i <weights[i], Y[i]> with respect to q, dq, ddq of each row to slopes, (rows x
  /// 3 n).
  virtual void add_gradient(const MotionSamples& motion, const std::vector<MatrixXd>& weights,
                            MatrixXd& slopes) const = 0;
};

using ColumnSources = std::vector<std::unique_ptr<ColumnSource>>;

/// Columns of the inertial parameters of all bodies.
std::unique_ptr<ColumnSource> body_columns(const Model& arm);

/// Columns of the parameters of one effect of the arm.
///
/// @param rounding  (n) speeds below which the sign of a velocity is smoothed, so that a search has
///   derivatives; zero: unmodified. Effects with memory are never smoothed.
std::unique_ptr<ColumnSource> effect_columns(const Model& arm, const EffectTerm& term,
                                             const VectorXd& rounding);

/// Part of the rigid bodies' torques with parameters phi.
enum class TorquePart {
  kWhole,        ///< evaluated at the motion
  kGravityOnly,  ///< evaluated at rest: the gravity torque
};

/// One column: the torques of the arm's bodies in the rows of selected joints, as for a torque gain
/// or a direction of gravity.
///
/// @param joints  (n) nonzero for the joints whose rows are used.
std::unique_ptr<ColumnSource> torque_column(const Model& arm, const VectorXd& phi, TorquePart part,
                                            const VectorXd& joints);

/// Selected columns of another source, in this order.
std::unique_ptr<ColumnSource> some_columns(std::unique_ptr<ColumnSource> from,
                                           std::vector<int> kept);

}  // namespace veridyn
