#pragma once

#include <memory>
#include <vector>

#include "veridyn/dynamics/regressor_batch.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/motion_samples.hpp"

namespace veridyn {

/// Columns of a regressor along a motion, and the way back from them to the motion. Immutable:
/// serves several threads.
class ColumnSource {
 public:
  virtual ~ColumnSource() = default;

  /// How many columns there are.
  virtual int count() const = 0;

  /// True if a row depends on the rows before it.
  virtual bool remembers() const { return false; }

  /// Those that can differ from zero in the rows of a joint, ascending.
  virtual std::vector<int> columns(int joint) const = 0;

  /// Y[i](row, c): what column columns(i)[c] holds in joint i's row; sized here.
  virtual void evaluate(const MotionSamples& motion, std::vector<MatrixXd>& Y) const = 0;

  /// Adds the derivatives of sum_i <weights[i], Y[i]> to slopes, (rows x 3 n): by q, dq, ddq of the
  /// row's sample.
  virtual void add_gradient(const MotionSamples& motion, const std::vector<MatrixXd>& weights,
                            MatrixXd& slopes) const = 0;
};

using ColumnSources = std::vector<std::unique_ptr<ColumnSource>>;

/// The inertial parameters of all bodies.
std::unique_ptr<ColumnSource> body_columns(const Model& arm);

/// The parameters of one effect of the arm.
///
/// @param rounding  (n) speeds below which a sign is rounded off, so that a search finds slopes;
///                  zero: the effect as it is. Effects with a memory are never rounded.
std::unique_ptr<ColumnSource> effect_columns(const Model& arm, const EffectTerm& term,
                                             const VectorXd& rounding);

/// What happens to the given part of the torques of rigid bodies with parameters phi.
enum class TorquePart {
  kWhole,        ///< they are asked for at the motion
  kGravityOnly,  ///< they are asked for at rest: how the arm's weight acts
};

/// One column: the torques of the arm's bodies in the rows of the joints that are chosen, as the
/// column of a torque gain or of a direction of gravity is.
///
/// @param joints  nonzero where the joint's row counts, (n).
std::unique_ptr<ColumnSource> torque_column(const Model& arm, const VectorXd& phi, TorquePart part,
                                            const VectorXd& joints);

/// Some columns of another source, in this order.
std::unique_ptr<ColumnSource> some_columns(std::unique_ptr<ColumnSource> from,
                                           std::vector<int> kept);

}  // namespace veridyn
