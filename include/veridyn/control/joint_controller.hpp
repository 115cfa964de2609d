// control/: laws, observers, compensation and supervision; nothing in a cycle allocates, throws or blocks.
#pragma once

#include <optional>

#include "veridyn/control/computed_torque.hpp"
#include "veridyn/control/control_cycle.hpp"
#include "veridyn/control/gravity_compensation.hpp"
#include "veridyn/control/joint_pid.hpp"
#include "veridyn/control/quintic_interpolator.hpp"
#include "veridyn/math/motion_samples.hpp"

namespace veridyn {

/// Sets the reference to the present point of a path.
inline void set_reference_from(const QuinticInterpolator& path, JointReference& reference) noexcept {
  reference.q = path.x();
  reference.dq = path.dx();
  reference.ddq = path.ddx();
}

/// Sets the reference to a row of a motion with velocities and accelerations.
inline void set_reference_from(const MotionSamples& motion, Eigen::Index row, JointReference& reference) noexcept {
  reference.q = motion.q.row(row).transpose();
  reference.dq = motion.dq.row(row).transpose();
  reference.ddq = motion.ddq.row(row).transpose();
}

enum class JointLaw {
  kComputedTorque,  ///< joints follow their reference, see ComputedTorque
  kGravity,         ///< for guiding by hand: gravity is compensated, and references are ignored
  /// Each joint on its own, see JointPid; friction and the error of the model are not compensated.
  kPid
};

struct JointControllerOptions {
  Gain kp = 400.0;  ///< K_p [1/s^2]; for kPid [N m/rad], [N/m]
  Gain kd = 40.0;   ///< K_d [1/s]; for kPid [N m s/rad], [N s/m]
  Gain ki = 0.0;    ///< for kPid only [N m/(rad s)], [N/(m s)]
  JointLaw law = JointLaw::kComputedTorque;
  CycleOptions cycle{};
};

/// Computes the torques of the drives from encoder positions and a reference of the joints, every cycle: a
/// ControlCycle around a law of the joints.
///
///   JointController controller(arm, {400, 40});
///   Measured measured(arm.joints());
///   robot.read(measured.q);
///   JointReference wanted = controller.reference_at(measured);
///   while (robot.read(measured.q)) robot.write(controller.update(measured, wanted, 1e-3));
///   if (controller.fault()) std::cerr << *controller.fault() << '\n';
///
/// Nothing allocates, throws or blocks after the constructor; one object serves one thread.
class JointController {
 public:
  /// @throws InvalidInput  as ControlCycle; gains that are not one or n numbers, none below zero.
  explicit JointController(const Model& arm, const JointControllerOptions& options = {});

  /// @param measured  signals as measured by the sensors. @param reference  true positions, (n).
  /// @param dt  [s] since the previous update, as measured. @returns (n) torques in the scale of the drives
  /// [N m], [N], always finite and within limits; valid until the next update().
  const VectorXd& update(const Measured& measured, const JointReference& reference, double dt) noexcept {
    measure(measured, dt);
    return act(reference);
  }
  /// update() in two steps, for a reference that depends on the present state.
  const ArmState& measure(const Measured& measured, double dt) noexcept {
    dt_ = dt;
    return cycle_.measure(measured, dt);
  }
  const VectorXd& act(const JointReference& reference) noexcept;

  /// A reference at rest at these measured positions. Allocates.
  JointReference reference_at(const Measured& measured) const;

  /// Calls ControlCycle::set_sent_torques().
  void set_sent_torques(const VectorRef& drive_torques) noexcept { cycle_.set_sent_torques(drive_torques); }

  bool hold() noexcept { return cycle_.hold(); }   ///< see ControlCycle::hold()
  void limp() noexcept { cycle_.limp(); }          ///< gravity compensation and a little damping, until resume()
  void resume() noexcept { cycle_.resume(); }      ///< ends both; the reference must begin at the arm's position
  void reset() noexcept;  ///< clears a fault and all observers

  std::optional<ControllerFault> fault() const noexcept { return cycle_.fault(); }
  int joints() const { return cycle_.joints(); }
  const ControlCycle& cycle() const { return cycle_; }
  const ArmState& state() const { return cycle_.state(); }  ///< evaluated at true positions

 private:
  ControlCycle cycle_;
  JointLaw law_;
  std::optional<ComputedTorque> computed_torque_;
  std::optional<GravityCompensation> gravity_;
  std::optional<JointPid> pid_;
  double dt_ = 0.0;  // [s]
  VectorXd error_, tau_;
};

}  // namespace veridyn
