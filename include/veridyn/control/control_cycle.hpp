#pragma once

#include <iosfwd>
#include <optional>

#include "veridyn/control/arm_state.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/control/gain.hpp"
#include "veridyn/control/model_error_observer.hpp"
#include "veridyn/control/safety_supervisor.hpp"
#include "veridyn/control/torque_uncertainty.hpp"
#include "veridyn/control/velocity_observer.hpp"
#include "veridyn/model/joint_sensors.hpp"

namespace veridyn {

/// Signals of an arm's sensors in one cycle.
struct Measured {
  /// Zero positions, without velocities and without a force sensor.
  explicit Measured(int joints) : q(VectorXd::Zero(joints)) {}
  VectorXd q;   ///< (n) encoder positions [rad], [m]
  VectorXd dq;  ///< (n) [rad/s], [m/s]; empty: those of the velocity observer
  double age = 0.0;        ///< [s] age of the positions
  double age_range = 0.0;  ///< [s] positions may be younger by this, see SafetyInput::sensor_age_range
  /// Wrench [force; moment] that the tip exerts on the world, about the tip and in world axes [N, N m].
  Vector6d wrench{Vector6d::Zero()};
  double wrench_age = 0.0;  ///< [s] age of the wrench
};

/// Layers below a law that check and limit its torque.
enum class Supervision {
  kSupervisor,  ///< SafetySupervisor: it also takes over on a fault, and holds the arm on command
  kLimits       ///< torques are limited, and nothing else is checked: for simulation
};

/// Convention of a cycle's positions and torques: with or without the errors of the sensors and drives.
enum class Signals {
  kOfSensors,  ///< uncorrected: in the scales of the model's sensors and drives, see JointSensors
  kTrue        ///< true values: the caller corrects sensor errors, or there are none
};

/// Settings of the observers, the compensation and the supervision around a control law.
struct CycleOptions {
  double velocity_bandwidth = 300.0;  ///< [1/s] bandwidth of VelocityObserver
  FrictionOptions friction{};         ///< share 0: friction is not compensated
  double error_bandwidth = 10.0;      ///< [1/s] bandwidth of ModelErrorObserver; 0: off
  /// Largest torque of ModelErrorObserver [N m], [N]; nullopt: the model's uncertainty in the present motion,
  /// see TorqueUncertainty.
  std::optional<Gain> error_limit{};
  /// Limits of the supervisor; nullopt: those of the robot file, see safety_limits().
  std::optional<SafetyLimits> limits{};
  /// Torque limit of the drives [N m], [N] for coordinates without one in the robot file; 0: such a file is
  /// refused.
  double torque = 0.0;
  Supervision supervision = Supervision::kSupervisor;
  Signals signals = Signals::kOfSensors;
};

/// A fault: its cause, joint and time.
struct ControllerFault {
  SafetyFault what = SafetyFault::kNone;
  std::optional<JointIndex> joint;  ///< nullopt: the fault concerns no single joint
  double time = 0.0;                ///< [s] time since the controller was made or reset
};
/// Writes "a position limit of joint 2 at 1.204 s"; joints count from 1.
std::ostream& operator<<(std::ostream& out, const ControllerFault& fault);

/// The tip, or default_tip() if it has no frame. @throws InvalidInput  the arm has no joints.
Tip chosen_tip(const Model& arm, const Tip& tip = {});

/// One cycle of control around a law, in a fixed order: sensor errors are removed, velocities observed and
/// the state evaluated; then the law's torque is extended by friction compensation and by the torque of the
/// model's error, supervised, limited, and converted to that of the drives. The observer is informed of the
/// torque that the limits removed. JointController and TipController are a ControlCycle with a law; a law of
/// your own is used in the same way:
///
///   ControlCycle cycle(arm, tip, {});
///   every cycle: const ArmState& state = cycle.measure(measured, dt);
///                cycle.command(law.update(state, ...));
///                cycle.add_friction(wanted.dq, error);    // if wanted
///                cycle.add_model_error(law.acceleration());  // if wanted
///                drives.write(cycle.send());
///
/// Nothing allocates, throws or blocks after the constructor; one object serves one thread. Vectors
/// have the sizes of the constructor; debug builds assert it.
class ControlCycle {
 public:
  /// @throws InvalidInput  a body or an effect has no values, an option is out of range, the tip's
  /// frame does not exist, or a coordinate has no torque limit.
  ControlCycle(const Model& arm, const Tip& tip, const CycleOptions& options);

  /// Begins a cycle. @param dt  [s] since the previous one.
  /// @returns the state with true positions, valid until the next cycle.
  const ArmState& measure(const Measured& measured, double dt) noexcept;

  /// Sets the torque of the law (n) [N m], [N].
  void command(const VectorRef& tau) noexcept { tau_ = tau; }
  /// Sets the positions (n) with which the supervisor compares the measured ones in this cycle.
  void set_wanted_positions(const VectorRef& q_wanted) noexcept { input_.q_wanted = q_wanted; }
  /// Adds FrictionCompensation::update() with these arguments to the command.
  void add_friction(const VectorRef& dq_wanted, const VectorRef& error) noexcept;
  /// Adds the torque of ModelErrorObserver to the command; without this call the cycle clears the observer.
  /// @param y  (n) acceleration that the torque would cause if the model were exact.
  void add_model_error(const VectorRef& y) noexcept;
  /// Replaces the command of this cycle by gravity compensation and a little damping, so that the arm yields.
  /// Clears the observer.
  void command_gravity_compensation() noexcept;

  /// Ends a cycle. @returns (n) torques in the scale of the drives, always finite and within limits.
  const VectorXd& send() noexcept;

  /// Sets the torques (n) that the drives produced, in their scale. Call it before the next cycle if the result
  /// of send() is limited further.
  void set_sent_torques(const VectorRef& drive_torques) noexcept;

  /// The supervisor brakes the arm and holds it where it stops, until resume(). Returns false, and does
  /// nothing, during a fault or without a supervisor.
  bool hold() noexcept;
  /// Calls command_gravity_compensation() in every cycle until resume().
  void limp() noexcept;
  /// Ends hold() and limp(). The reference must then begin at the arm's position.
  void resume() noexcept;
  /// Clears the observers' estimates, for example while the motors are off. A fault remains.
  void reset_observers() noexcept;
  /// Clears a fault too, and restarts the time that ControllerFault contains.
  void reset() noexcept;
  /// Switches the motors off: zero torques and no checks until reset(). Clears a fault.
  void disable() noexcept;

  /// The first fault, or a later one with a stronger action; nullopt: none since reset().
  std::optional<ControllerFault> fault() const noexcept;

  int joints() const { return state_.joints(); }
  const ArmState& state() const { return state_; }  ///< evaluated at true positions
  /// Measured wrench of this cycle.
  const Vector6d& wrench() const { return wrench_; }
  const JointSensors& sensors() const { return sensors_; }
  const VectorXd& commanded() const { return tau_; }  ///< (n) true torques before limits
  const VectorXd& torque() const { return sent_; }    ///< (n) true torques after all limits
  const SafetyLimits& limits() const { return limits_; }
  const SafetySupervisor* supervisor() const { return safety_ ? &*safety_ : nullptr; }
  FrictionCompensation* friction() { return friction_ ? &*friction_ : nullptr; }
  const ModelErrorObserver& error() const { return error_; }

 private:
  JointSensors sensors_;
  VelocityObserver velocity_;
  ArmState state_;
  std::optional<FrictionCompensation> friction_;
  std::optional<TorqueUncertainty> uncertainty_;
  ModelErrorObserver error_;
  SafetyLimits limits_;
  std::optional<SafetySupervisor> safety_;
  SafetyInput input_;
  SafetyFault known_ = SafetyFault::kNone;
  double dt_ = 0.0, time_ = 0.0, fault_time_ = 0.0;  // [s]
  bool observes_ = false;  // ModelErrorObserver is on
  bool observed_ = false;  // add_model_error() was called in this cycle
  bool limp_ = false, off_ = false;
  Vector6d wrench_{Vector6d::Zero()};
  int until_limit_ = 0;    // cycles until the observer's limit is evaluated again
  VectorXd q_, dq_, y_, tau_, sent_, drive_;
};

}  // namespace veridyn
