#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/control/computed_torque.hpp"
#include "veridyn/control/control_cycle.hpp"
#include "veridyn/control/impedance.hpp"
#include "veridyn/control/joint_pid.hpp"
#include "dvrk/run/controllers/motion_controller.hpp"

namespace veridyn::dvrk {

enum class ControlLaw {
  kComputedTorque,  ///< joints follow, with the model as feed-forward
  /// The tip follows the path of the joints' set points like a spring. The approach uses
  /// kComputedTorque, because the arm may be stretched there, where a tip cannot be controlled.
  /// Motions with a pose near a singularity are refused: a joint that drifts there would return
  /// with a jerk.
  kImpedance,
  kGravity  ///< the arm is weightless; set points do not count
};

struct ModelControlOptions {
  ControlLaw law = ControlLaw::kComputedTorque;
  double frequency = 20.0;   ///< [rad/s] of both poles of the position error
  std::string tip;           ///< frame of the impedance; empty: see default_tip()
  double tip_mass = 2.0;     ///< [kg] that the tip appears to have
  double stiffness = 800.0;  ///< [N/m] of the tip; damping is critical
  /// The user's own gains in place of those that `frequency`, `tip_mass` and `stiffness` give.
  std::optional<JointGains> joint_gains;
  std::optional<ImpedanceGains> tip_gains;
  /// Largest output of ModelErrorObserver, as a share of the largest torque. Under impedance the
  /// tip, which has no force sensor here, pushes with up to that much beyond its spring.
  double model_error = 0.05;
  FrictionOptions friction;
  /// [s] between two cycles, and of positions: beyond, the run ends.
  double longest_gap = 0.03;
  VectorXd position_steps;  ///< (n of the arm) ArmUnits::joint_steps(); empty: encoders without steps
};

/// Errors of encoders and currents that the model knows are undone (JointSensors): a motion is led in
/// true positions, while a run, its limits and its rows count as the boards do, see to_board_positions().
///
/// The laws of control/ for a run: torques of the model's joints, which are the arm's first ones,
/// by a law; those of the others by a PID. SafetySupervisor watches the model's joints: numbers,
/// jumps and age of positions, time of the cycle, position and velocity limits of the robot file,
/// torques that stay at their limits. Its fault ends the run, that is, power goes off; its own
/// actions (hold, freeze) are not used.
///
///   ModelController control(model, gains, largest_torques(arm), options);
///   run_motion(arm, link, motion, control, run_options, stop);
class ModelController final : public MotionController {
 public:
  /// @param rest  gains of all joints of the arm; those of the model's joints are not used.
  /// @param largest  (n of the arm) torques of the motors; the robot file may ask for less.
  /// @throws InvalidInput  a model without values or with more joints than the arm; options that
  ///                       cannot be; as the classes of control/.
  ModelController(const Model& model, const PidGains& rest, const VectorXd& largest,
                  const ModelControlOptions& options = {});

  void reset() noexcept override;
  void motion_begins() noexcept override { moves_ = true; }
  bool torques(const BoardArmState& state, const JointReference& wanted, const CycleTimes& times,
               VectorXd& tau) noexcept override;
  void sent(const VectorXd& tau) noexcept override;  ///< as the drives count
  std::string refusal_reason() const override;
  bool follows() const override { return options_.law != ControlLaw::kGravity; }
  MotionLimits limits() const override;
  void require_possible(const MotionSamples& motion) const override;
  MotionSamples to_board_positions(const MotionSamples& motion) const override;

  int joints() const { return cycle_.joints(); }  ///< Joints of the model
  /// Effects of the model that these laws leave out, in words.
  const std::vector<std::string>& left_out() const { return cycle_.state().left_out(); }
  const SafetySupervisor& safety() const { return *cycle_.supervisor(); }
  const JointSensors& sensors() const { return cycle_.sensors(); }

 private:
  void require_tip_led(const MotionSamples& motion) const;
  void computed_torque() noexcept;
  void impedance() noexcept;

  ModelControlOptions options_;
  Model model_;
  ControlCycle cycle_;
  ComputedTorque computed_torque_;
  TipKinematics path_;
  Impedance impedance_;
  GravityCompensation gravity_;
  JointPid rest_;
  Measured measured_;      // of the model's joints
  JointReference wanted_;  // likewise
  TaskReference task_;
  VectorXd off_, sent_;
  bool moves_ = false;  // during the motion, not during the approach
};

}  // namespace veridyn::dvrk
