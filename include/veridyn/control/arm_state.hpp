#pragma once

#include <string>
#include <vector>

#include "veridyn/control/tip_kinematics.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// All quantities of an arm at one instant that controllers use, evaluated once per cycle (thesis
/// 7.1, 7.2):
///
///   tau = M(q) ddq + bias(q, dq) + friction,    bias = C dq + g + springs, offsets, cables, ripple
///
/// M includes the rotors (rotor_inertia); friction belongs to FrictionCompensation. Effects that
/// depend on the time since the start of a recording, or that describe measured motion only, are
/// not included, see left_out(). Nothing allocates after the constructor; one object serves one
/// thread.
///
///   ArmState state(arm);                        // joint control; ArmState(arm, {"tool"}) for a tip
///   sensors.correct_positions(q);               // q as encoders show it -> true, see JointSensors
///   state.update(q, dq);
///   tau = state.mass_matrix() * ddq_wanted + state.bias();
class ArmState {
 public:
  /// Uses default_tip(arm), which joint control does not need. @throws InvalidInput  as below.
  explicit ArmState(const Model& arm);

  /// @throws InvalidInput  a body or an effect has no values, or the tip's frame does not exist.
  ArmState(const Model& arm, const Tip& tip);

  /// @param q, dq  n entries each, true positions and velocities: [rad], [m] where a joint is
  /// prismatic. Debug builds assert the sizes; another size is undefined in release builds, as in
  /// every update() of this library.
  void update(const VectorRef& q, const VectorRef& dq) noexcept;

  int joints() const { return tip_.joints(); }
  const VectorXd& q() const { return q_; }
  const VectorXd& dq() const { return dq_; }

  const TipKinematics& tip() const { return tip_; }
  const MatrixXd& mass_matrix() const { return M_; }  ///< (n x n) [kg m^2], [kg m], [kg]
  const VectorXd& bias() const { return bias_; }      ///< (n) [N m], [N]
  const VectorXd& rigid_bias() const { return h_; }   ///< C dq + g alone, (n)

  /// Effects of the model that no controller of this library takes into account, in words.
  const std::vector<std::string>& left_out() const { return left_out_; }

 private:
  TipKinematics tip_;
  RigidBodyDynamics rigid_;
  MatrixXd rotors_;  // inertia that effects add to M
  std::vector<BoundEffect> forces_;
  std::vector<std::string> left_out_;
  VectorXd q_, dq_, rest_, h_, bias_;
  MatrixXd M_;
};

}  // namespace veridyn
