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
  /// The tip follows the path of the joints' set points like a spring. The approach uses kComputedTorque,
  /// because the arm may be stretched there, where a tip cannot be controlled. Motions with a pose near a
  /// singularity are rejected: a joint that drifts there would return with a jerk.
  kImpedance,
  kGravity  ///< gravity is compensated; set points are ignored
};

struct ModelControlOptions {
  ControlLaw law = ControlLaw::kComputedTorque;
  double frequency = 20.0;   ///< [rad/s] magnitude of both poles of the position error
  std::string tip;           ///< frame of the impedance; empty: see default_tip()
  double tip_mass = 2.0;     ///< [kg] apparent mass of the tip
  double stiffness = 800.0;  ///< [N/m] stiffness of the tip; damping is critical
  /// The user's gains in place of those computed from `frequency`, `tip_mass` and `stiffness`.
  std::optional<JointGains> joint_gains;
  std::optional<ImpedanceGains> tip_gains;
  /// Largest output of ModelErrorObserver, as a share of the largest torque. With kImpedance, which has no
  /// force sensor here, the tip pushes with up to this torque in addition to its spring.
  double model_error = 0.05;
  FrictionOptions friction;
  /// [s] largest time between two cycles, and largest age of positions; beyond, the run ends.
  double longest_gap = 0.03;
  VectorXd position_steps;  ///< (n of the arm) ArmUnits::joint_steps(); empty: encoders without steps
};

/// Controls the model's joints, which are the arm's first ones, by one of the laws of control/, and the other
/// joints by a PID. SafetySupervisor checks the model's joints: invalid numbers, jumps and age of positions,
/// time of the cycle, position and velocity limits of the robot file, torques that stay at their limits. Its
/// fault ends the run with power-off; its own actions (hold, freeze) are not used.
///
/// Errors of encoders and currents in the model are removed (JointSensors): the motion uses true positions,
/// while a run, its limits and its rows use those of the boards, see to_board_positions().
///
///   ModelController control(model, gains, largest_torques(arm), options);
///   run_motion(arm, link, motion, control, run_options, stop);
class ModelController final : public MotionController {
 public:
  /// @param rest  gains of all joints of the arm; those of the model's joints are not used.
  /// @param largest  (n of the arm) torques of the motors; the robot file may have smaller ones.
  /// @throws InvalidInput  a model without values or with more joints than the arm; invalid options; as the
  /// classes of control/.
  ModelController(const Model& model, const PidGains& rest, const VectorXd& largest,
                  const ModelControlOptions& options = {});

  void reset() noexcept override;
  void motion_begins() noexcept override { moves_ = true; }
  bool torques(const BoardArmState& state, const JointReference& wanted, const CycleTimes& times,
               VectorXd& tau) noexcept override;
  void set_sent_torques(const VectorXd& tau) noexcept override;  ///< tau in the scale of the drives
  std::string refusal_reason() const override;
  bool follows() const override { return options_.law != ControlLaw::kGravity; }
  MotionLimits limits() const override;
  void require_possible(const MotionSamples& motion) const override;
  MotionSamples to_board_positions(const MotionSamples& motion) const override;

  int joints() const { return cycle_.joints(); }  ///< Joints of the model
  /// Effects of the model that these laws do not include, in words.
  const std::vector<std::string>& left_out() const { return cycle_.state().left_out(); }
  const SafetySupervisor& safety() const { return *cycle_.supervisor(); }
  const JointSensors& sensors() const { return cycle_.sensors(); }

 private:
  void require_tip_led(const MotionSamples& motion) const;  ///< throws InvalidInput at a singular pose
  void computed_torque() noexcept;  ///< commands cycle_ to follow wanted_ by joints
  void impedance() noexcept;  ///< commands cycle_ to follow the tip of wanted_ like a spring

  ModelControlOptions options_;
  Model model_;
  ControlCycle cycle_;
  ComputedTorque computed_torque_;
  TipKinematics path_;
  Impedance impedance_;
  GravityCompensation gravity_;
  JointPid rest_;
  Measured measured_;      // measurements of the model's joints
  JointReference wanted_;  // reference of the model's joints
  TaskReference task_;
  VectorXd off_, sent_;
  bool moves_ = false;  // during the motion, not during the approach
};

}  // namespace veridyn::dvrk
