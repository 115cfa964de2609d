#pragma once

#include <string>
#include <vector>

#include "veridyn/control/arm_state.hpp"
#include "veridyn/control/cooperative_controller.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/control/inverse_kinematics.hpp"
#include "veridyn/cooperation/scenario.hpp"

namespace veridyn {

/// An arm as its controller models it, for MotionPlan.
struct PlannedArm {
  Model model;
  Eigen::Matrix3d R_world_base{Eigen::Matrix3d::Identity()};
  Eigen::Vector3d p_world_base{Eigen::Vector3d::Zero()};
  VectorXd torque;  ///< (n) largest torques of the motors [N m], [N]
};

/// Executes commands of a scenario with the same controller and ideal arms: tips follow as a double
/// integrator (position loops) or as their impedance, members compute_forces according to their stiffness. During the
/// motion every arm must reach its tip positions within its joints' limits, the braking distance included,
/// within kSpeedShare of their velocities, and within its motors' torque by inverse dynamics; and the
/// controller must not stop. One object serves one thread.
class MotionPlan {
 public:
  /// @throws InvalidInput  as ArmState and the controller.
  MotionPlan(const Scenario& scenario, std::vector<PlannedArm> arms);

  /// State of a plan. Copies are independent.
  struct State {
    CooperativeController control;
    CooperativeInput seen;          ///< tips and forces
    std::vector<VectorXd> q;        ///< (n) of each arm
    std::vector<double> length;     ///< [m] length of each member without force
    std::vector<char> held;
    double time = 0.0;              ///< [s] since the plan began
  };
  /// Initial state at these joints, without commands.
  State initial_state(const std::vector<VectorXd>& q);
  /// State in the middle of a run, with the measured joints q, (n) of each arm.
  State state_during_run(const CooperativeController& control, const CooperativeInput& seen,
                  const std::vector<VectorXd>& q) const;

  /// @param seconds  [s] to plan. @returns the reason for which the commands cannot be executed, with place
  /// and numbers; empty if they can. The state is then that at the end.
  std::string play(State& state, const std::vector<ScenarioCommand>& commands, double seconds);

  /// Plans one command during a run, until all motion has settled after its end. A command that takes longer
  /// than kLongest is planned with that duration.
  std::string check_command(State state, ScenarioCommand command);

  /// The same for a velocity of the object [m/s] that lasts for `seconds` and is then stopped.
  std::string jog(State state, const Eigen::Vector3d& velocity, double seconds);

  static constexpr double kSpeedShare = 0.95;  ///< share of a joint's velocity limit that a plan may use
  static constexpr double kSettled = 0.3;      ///< [s] planned after a command's end
  static constexpr double kLongest = 5.0;      ///< [s] longest planned command from a line, since planning takes time

 private:
  struct Arm {
    PlannedArm known;
    std::string name;
    ArmState state;
    FrictionCompensation friction;
    InverseKinematics inverse;
    TaskInverse rates;
    VectorXd none, dq, ddq, tau;
  };
  struct Tip {
    Eigen::Vector3d acceleration{Eigen::Vector3d::Zero()}, force{Eigen::Vector3d::Zero()};
  };
  std::string advance(State& state, double seconds);
  void compute_forces(State& state);
  void advance_tips(State& state, const std::vector<TipTarget>& targets);
  std::string joint_violation(State& state, std::size_t k);

  Scenario scenario_;
  std::vector<Arm> arms_;
  std::vector<Tip> tips_;
  std::vector<Eigen::Vector3d> walls_;  // a point on each wall
};

}  // namespace veridyn
