#pragma once

#include <vector>

#include "veridyn/control/friction_compensation.hpp"

namespace veridyn {

struct AdaptiveFrictionOptions {
  bool enabled = false;  ///< off by default
  double rate = 0.5;     ///< [1/s] rate of forgetting and of adaptation; time counts in motion only
  double least = 0.0;    ///< lower bound of k, as a share of the identified friction
  double most = 2.0;
  Deadband velocity{0.01, 0.005};  ///< deadband of the axis' velocity; k is not updated within it
};

/// Online update of friction, which changes as grease ages and warms (proposed in the outlook of the thesis,
/// chapter 8). In motion, an axis needs, in addition to the torque of the model's bodies,
///
///   y = compensation + missing = k* F(direction, v) + b + c s,
///
/// where k* is the ratio of the arm's present friction to the identified friction F, s the position of the
/// axis, and b + c s every other error of the model near this position, mainly gravity. Least squares over the
/// last 1 / rate seconds of motion (exponential forgetting) estimate k*, b and c, and the compensated share k
/// follows:
///
///   dk/dt = rate (clamp(estimate of k*, least, most) - k).
///
/// Proof of convergence. y does not contain k, so the estimate does not depend on k: there is no
/// feedback through which k could drift. If y is k* F + b + c s + e, the estimate is
/// k* + sum(w r e) / sum(w r^2), with w the weights of the forgetting and r the part of F that
/// b + c s do not explain. Without e it is k* exactly, and |k - k*| falls as exp(-rate t) if k* lies
/// within the bounds. With an e of root mean square E, the error of the estimate is at most
/// E / rms(r), by Cauchy and Schwarz. Excitation: motion in one direction only, or in a direction that depends
/// on the position, makes r vanish. k stays constant unless sum(w r^2) exceeds a fifth of sum(w F^2), so that E
/// / rms(r) < sqrt(5) E / rms(F). Source: Slotine and Li, Applied Nonlinear Control, 1991,
/// section 8.7 (least squares with exponential forgetting, persistent excitation).
///
///   AdaptiveFriction adaptive(friction, options);   // options.enabled = true
///   every cycle: adaptive.update(state, error.missing(), 0.001, friction);
class AdaptiveFriction {
 public:
  /// @throws InvalidInput  bounds that do not contain the share of `friction`, or a rate below zero.
  explicit AdaptiveFriction(const FrictionCompensation& friction,
                            const AdaptiveFrictionOptions& options = {});

  /// @param missing  (n) torque that is missing beyond the compensation by `friction`:
  /// ModelErrorObserver::missing(), while the arm touches nothing. @param dt [s].
  /// Vectors have the sizes of the constructor; debug builds assert it.
  void update(const ArmState& arm, const VectorRef& missing, double dt,
              FrictionCompensation& friction) noexcept;

  /// k: the compensated share of the identified friction.
  double share(int axis) const { return axes_[axis].share; }

 private:
  struct Learned {
    double share = 1.0;
    double speed = 0.0;    // value at the previous update
    double applied = 0.0;  // compensation since the previous update
    double place = 0.0;    // s is counted from this position
    bool first = true;
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  // information matrix of the columns F, 1, s
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
  };
  void adapt(Learned& axis, double force, double s, double needed, double dt) const noexcept;  ///< one step of recursive least squares, for s and needed force
  AdaptiveFrictionOptions options_;
  std::vector<Learned> axes_;
};

}  // namespace veridyn
