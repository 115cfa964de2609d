#pragma once

#include <optional>

#include "veridyn/control/adaptive_friction.hpp"
#include "veridyn/control/control_cycle.hpp"
#include "veridyn/control/cooperative_controller.hpp"
#include "veridyn/control/impedance.hpp"
#include "veridyn/cooperation/scenario.hpp"

namespace veridyn {

/// Models and settings of one arm's loop.
struct ArmLoopSetup {
  Model model;  ///< model that the controller uses
  Tip tip{};
  Eigen::Matrix3d R_world_base{Eigen::Matrix3d::Identity()};
  Eigen::Vector3d p_world_base{Eigen::Vector3d::Zero()};
  ArmControl kind = ArmControl::kImpedance;
  ScenarioControl control{};
  VectorXd encoder_step{};  ///< (n) [rad], [m]; 0: exact
  VectorXd start{};         ///< (n) joints, which is also the posture
};

/// Sensors and controller of one arm: encoders, velocities, and either a position loop of the tip or an
/// impedance, with friction compensation and an observer of the model's error. Nothing allocates after the
/// constructor.
class ArmLoop {
 public:
  explicit ArmLoop(const ArmLoopSetup& setup);

  /// Reads the encoders: true positions, rounded to encoder steps.
  void measure(const VectorXd& q) noexcept;

  const Eigen::Vector3d& position() const { return position_; }  ///< Position of the tip in the world
  const Eigen::Vector3d& velocity() const { return velocity_; }  ///< [m/s] likewise
  /// Axes of the tip in the world.
  Eigen::Matrix3d rotation() const { return setup_.R_world_base * cycle_.state().tip().rotation(); }

  /// Torques (n) [N m], [N] for the next period.
  /// @param force  of the tip on the object as measured, in the world [N].
  const VectorXd& torque(const TipTarget& target, const Eigen::Vector3d& force) noexcept;

  /// Torques that the motors received after torque(), (n), if they differ from its result.
  void set_sent_torques(const VectorXd& tau) noexcept { cycle_.set_sent_torques(tau); }

  /// Switches to a position loop at the present position, plus TipTarget::relief.
  void freeze() noexcept;

  /// While targets are held: keeps the arm's position while the force is within `bound` [N]; beyond it the
  /// arm yields like a light damped mass, until the force has decreased and the tip rests, and then holds the
  /// new position. Call it every cycle before torque(). @param force  as for torque().
  void hold_within(double bound, const Eigen::Vector3d& force) noexcept;
  /// True while the arm yields: it is then not expected to rest.
  bool yields() const { return yielding_; }
  /// Torque of the observer of model errors, (n) [N m], [N].
  const VectorXd& extra_torque() const { return cycle_.error().torque(); }

 private:
  void compensate_friction(const TaskReference& wanted) noexcept;
  bool yields_to_forces() const { return setup_.kind == ArmControl::kImpedance && !frozen_; }
  Impedance& acting() { return yielding_ ? yielding_loop_ : yields_to_forces() ? impedance_ : position_loop_; }
  TaskReference reference(const TipTarget& target) const noexcept;

  ArmLoopSetup setup_;
  double period_;
  ControlCycle cycle_;
  Impedance impedance_, position_loop_, yielding_loop_;
  TaskInverse inverse_;
  std::optional<AdaptiveFriction> adaptive_;
  Measured measured_;
  VectorXd rest_, joint_error_, wanted_dq_;
  bool frozen_ = false, yielding_ = false;
  double bound_ = 0.0;  // [N] bound of the force while yielding
  Eigen::Vector3d position_{Eigen::Vector3d::Zero()}, velocity_{Eigen::Vector3d::Zero()};
  Eigen::Vector3d frozen_at_{Eigen::Vector3d::Zero()};
  Eigen::Vector3d relief_{Eigen::Vector3d::Zero()};  // last requested relief
};

}  // namespace veridyn
