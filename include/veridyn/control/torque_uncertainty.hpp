#pragma once

#include <vector>

#include "veridyn/control/arm_state.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

struct UncertaintyOptions {
  /// Relative deviation of every parameter, for models without the statistics of their identification.
  double relative = 0.1;
  double deviations = 3.0;  ///< number of standard deviations of a threshold
  /// Speed of an axis below which its friction may have any value up to its level.
  Deadband velocity{0.01, 0.005};
};

/// Uncertainty of a model's torque, joint by joint, for the present motion:
///
///   u_i = deviations * sqrt( sum over parameters (Y_i sigma)^2 + unexplained_i^2 ) + friction
///
/// An identified model provides the covariance of its base parameters; the unexplained part is the relative
/// error on its training recordings times the joint's rms torque in the standard motion. For any
/// other model the unexplained part is zero, and every inertial parameter has a standard deviation
/// of `relative` times its value, independently. The uncertainty of a friction is deviations / 3 times
/// `relative` of its force, and its whole level at rest. Nothing allocates after the constructor.
///
///   TorqueUncertainty uncertainty(arm);
///   every cycle: error.set_limit(uncertainty.update(state, control.acceleration()));
class TorqueUncertainty {
 public:
  /// @throws InvalidInput  an option that is not above zero; a body or a friction without values.
  explicit TorqueUncertainty(const Model& arm, const UncertaintyOptions& options = {});

  /// @param ddq  (n) wanted acceleration. @returns u (n) [N m], [N].
  /// Vectors have the sizes of the constructor; debug builds assert it.
  const VectorXd& update(const ArmState& arm, const VectorRef& ddq) noexcept;

  const VectorXd& torque() const { return u_; }

  /// True if the covariance comes from the model's identification.
  bool identified() const { return identified_; }

 private:
  void read_identified(const Model& arm);  ///< sets identified_, column_, factor_ and unexplained_ if base parameters have scatter
  void add_friction(const ArmState& arm) noexcept;  ///< adds the uncertainty of friction to u_

  UncertaintyOptions options_;
  TorqueRegressor regressor_;
  FrictionCompensation friction_;
  bool identified_ = false;
  VectorXd unexplained_;     // (n) [N m], [N] rms
  std::vector<int> column_;  // columns of Y with uncertain parameters
  MatrixXd factor_;          // (factors x columns) F', covariance F F'; only a diagonal without a covariance
  MatrixXd Y_;               // (n x 10 bodies)
  MatrixXd sum_;             // (factors x n) F' Y', or (1 x n) squares
  VectorXd u_;
};

}  // namespace veridyn
