#pragma once

#include <vector>

#include "veridyn/control/arm_state.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/kinematics/recursion.hpp"
#include "veridyn/kinematics/tree.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

struct UncertaintyOptions {
  /// Of every parameter, where the model does not say how well it was identified.
  double relative = 0.1;
  double deviations = 3.0;  ///< standard deviations that a threshold stands for
  /// Below this speed of an axis its friction may be anything up to its level.
  Deadband velocity{0.01, 0.005};
};

/// By how much the torque of a model may be wrong, joint by joint, in this motion:
///
///   u_i = deviations * sqrt( sum over parameters (Y_i sigma)^2 + unexplained_i^2 ) + friction
///
/// A MODEL with a covariance of its base parameters is asked for it; what no parameter explains is
/// its relative error on the recordings that it learned from times the joint's rms torque in the
/// standard motion. Of any other model nothing is unexplained, and
/// every inertial parameter is taken to be `relative` of its value uncertain, independently.
/// Friction is uncertain by deviations / 3 times `relative`, and wholly so at rest. Nothing
/// allocates after the constructor.
///
///   TorqueUncertainty uncertainty(arm);
///   every cycle: error.set_limit(uncertainty.update(state, control.acceleration()));
class TorqueUncertainty {
 public:
  /// @throws InvalidInput  an option that is not above zero; a body or a friction without values.
  explicit TorqueUncertainty(const Model& arm, const UncertaintyOptions& options = {});

  /// @param ddq  (n) acceleration, as wanted. @returns u (n) [N m], [N].
  /// Sizes are those of the constructor; another one is a fault of the program, asserted in debug
  /// builds alone.
  const VectorXd& update(const ArmState& arm, const VectorXd& ddq) noexcept;

  const VectorXd& torque() const { return u_; }

  /// True if the covariance is the model's own.
  bool identified() const { return identified_; }

 private:
  void read_identified(const Model& arm);
  void add_parameters() noexcept;
  void add_friction(const ArmState& arm) noexcept;

  UncertaintyOptions options_;
  Tree tree_;
  Recursion<double> recursion_;
  FrictionCompensation friction_;
  bool identified_ = false;
  VectorXd unexplained_;     // (n) [N m], [N] rms
  std::vector<int> column_;  // columns of Y that are uncertain
  MatrixXd factor_;          // (columns x factors) F, covariance F F'
  MatrixXd sum_;             // (n x factors) Y F
  VectorXd u_, none_;
};

}  // namespace veridyn
