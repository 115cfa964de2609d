#pragma once

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Velocities from encoder positions: a tracking filter with both poles at -bandwidth, exact at any
/// cycle time,
///
///   predict  q^ += dq^ dt + a dt^2 / 2,  dq^ += a dt
///   correct  q^ += (1 - p^2)(q - q^),    dq^ += (1 - p)^2 (q - q^) / dt,   p = exp(-bandwidth dt)
///
/// Without the acceleration a the velocity lags by 2 / bandwidth; an encoder step becomes a pulse
/// of at most step * bandwidth^2 dt. Source: the critically damped alpha-beta filter, Benedict and
/// Bordner, IRE Trans. Automatic Control 7(4), 1962.
///
///   VelocityObserver velocity(3);
///   every cycle: dq = velocity.update(q, zeros, 0.001);
class VelocityObserver {
 public:
  /// @param bandwidth  [1/s] @throws InvalidInput  not above zero.
  explicit VelocityObserver(int joints, double bandwidth = 300.0);

  /// @param ddq  (n) expected acceleration; zeros if unknown. @param dt  [s] since the last call. Constant offsets of the encoders have no
  /// effect.
  /// @returns dq (n), zero at the first update(). Positions that are not finite are skipped: pass NaN if no
  /// new sample has arrived, and the velocity is extrapolated. Nothing changes if dt is not finite or not
  /// above zero.
  /// Vectors have the sizes of the constructor; debug builds assert it.
  const VectorXd& update(const VectorRef& q, const VectorRef& ddq, double dt) noexcept;

  /// Restarts with the next position.
  void reset() noexcept;

  const VectorXd& dq() const { return dq_; }
  const VectorXd& q() const { return q_; }  ///< smoothed positions

 private:
  double bandwidth_;
  VectorXd q_, dq_;
  bool first_ = true;
};

}  // namespace veridyn
