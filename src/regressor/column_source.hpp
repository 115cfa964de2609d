#pragma once

#include <memory>
#include <vector>

#include "veridyn/dynamics/torque_regressor.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/motion_samples.hpp"

namespace veridyn {

/// Columns of a regressor along a motion, with the chain rule back to the motion. Immutable: serves
/// several threads.
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

  /// Adds the derivatives of sum_i <weights[i], Y[i]> to slopes, (rows x 3 n): by q, dq, ddq of the
  /// row's sample.
  virtual void add_gradient(const MotionSamples& motion, const std::vector<MatrixXd>& weights,
                            MatrixXd& slopes) const = 0;
};

using ColumnSources = std::vector<std::unique_ptr<ColumnSource>>;

/// Columns of the inertial parameters of all bodies.
std::unique_ptr<ColumnSource> body_columns(const Model& arm);

/// Columns of the parameters of one effect of the arm.
///
/// @param rounding  (n) speeds below which a sign is smoothed, so that a search has derivatives;
/// zero: unmodified. Effects with memory are never smoothed.
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
/// @param joints  nonzero where the joint's row counts, (n).
std::unique_ptr<ColumnSource> torque_column(const Model& arm, const VectorXd& phi, TorquePart part,
                                            const VectorXd& joints);

/// Selected columns of another source, in this order.
std::unique_ptr<ColumnSource> some_columns(std::unique_ptr<ColumnSource> from,
                                           std::vector<int> kept);

}  // namespace veridyn
