#pragma once

#include <array>
#include <optional>

#include "veridyn/control/arm_state.hpp"
#include "veridyn/control/gravity_compensation.hpp"
#include "veridyn/control/torque_uncertainty.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

enum class SafetyState {
  kDisabled,  ///< motors off
  kHoming,    ///< the controller moves the arm, at reduced speed
  kReady,     ///< the arm rests, and activate() is allowed
  kActive,    ///< the controller moves the arm
  kHolding,   ///< holds position on command; activate() continues
  kFault      ///< the safe action of the fault is applied, until reset()
};

/// Cause of a fault. The first check that fails sets it: sensors first, then motors, motion, force.
enum class SafetyFault {
  kNone,
  kNotFinite,    ///< a position, a velocity or a time is NaN or infinite
  kSensorAge,    ///< positions are older than allowed
  kEncoderJump,  ///< a position changed by more in one cycle than the joint can move
  kController,   ///< the controller's torque is NaN or infinite
  kOverrun,      ///< a cycle took longer than allowed
  kPosition,     ///< a joint is beyond a limit, or too fast to stop before it
  kVelocity,
  kTracking,    ///< a joint is too far from its wanted position
  /// the controller requests more than the motor's limit, or nearly as much at a standstill, for too long
  kTorque,
  kForce,       ///< the force at the tip is larger than allowed
  kForceSensor,  ///< the force is NaN or infinite, older than allowed, or disagrees with the
                 ///< joints' torques
  /// a held arm does not come to rest, or after a fault it is faster than `runaway` allows
  kNotHeld
};

/// Action applied to the motors.
enum class SafetyAction {
  kMotorsOff,  ///< zero torque (and brakes, if the arm has them)
  kPass,       ///< the controller's torque, within the motors' limits
  kHold,       ///< brakes with the help of the model, then holds the position where the arm stopped
  kRelease,    ///< gravity compensation and damping only: yields to external forces
  /// The torque that held the arm at its last valid position plus, decaying with `braking`, most of the torque that
  /// stops its last valid momentum; no feedback. For counterbalanced arms; others need their brakes.
  kFreeze
};

/// Fixed text of a state or a fault, such as "a position limit".
const char* describe(SafetyState state) noexcept;
const char* describe(SafetyFault fault) noexcept;

/// The action of a fault: kMotorsOff for an arm that is not held, kFreeze if positions are unreliable, kRelease
/// for forces, kHold for all others. Of several faults the one with the strongest action applies; kMotorsOff is
/// the strongest, kHold the weakest.
SafetyAction action_of(SafetyFault fault) noexcept;

struct SafetyLimits {
  VectorXd lower, upper;              ///< (n) [rad], [m]
  VectorXd velocity;                  ///< (n) [rad/s], [m/s]
  VectorXd torque;                    ///< (n) limit of the motors [N m], [N]
  VectorXd tracking;                  ///< (n) wanted minus measured position [rad], [m]
  VectorXd resolution;                ///< (n) resolution of positions: one step of an encoder; empty: zero
  double force = 15.0;                ///< [N] largest force at the tip
  double force_disagreement = 6.0;    ///< [N] largest difference between the sensor and MomentumObserver
  double disagreement_seconds = 0.1;  ///< [s] shortest duration of a difference that is a fault
  double sensor_age = 0.003;          ///< [s] largest age of positions
  double force_age = 0.01;            ///< [s] largest age of the force
  double overrun = 0.005;             ///< [s] longest time between two updates
  double torque_seconds = 0.2;        ///< [s] longest motor saturation
  double homing_share = 0.2;          ///< share of the velocity limit while homing
  double braking = 30.0;              ///< [1/s]: braking is -braking dq; stops within dq / braking
  /// [s] within which the kinetic energy of a held arm must decrease to a half. Braking alone takes ln 2 / (2
  /// braking) = 12 ms; a motor at its limit takes longer.
  double held_seconds = 0.1;
  /// Share of the velocity limits below which a held arm counts as at rest. From then on a spring of 100 1/s^2
  /// holds its position: a constant torque error moves the joint by a hundredth of the acceleration that it
  /// causes.
  double rest_share = 0.05;
  double runaway = 1.5;  ///< factor of the velocity limit above which an arm with a fault is switched off
  /// Relative error of every parameter, UncertaintyOptions::relative: a holding torque may deviate from the
  /// model by at most TorqueUncertainty at rest plus the effect of the measured force.
  double model_error = 0.1;
};

/// Position, velocity and effort limits of the robot file; `torque` [N m], [N] for each joint without an effort limit; a
/// tracking error of 5 % of the range, or 0.1 rad or 0.02 m without one.
SafetyLimits safety_limits(const Model& arm, double torque);

/// Inputs of the supervisor in a cycle, in addition to the arm's state.
struct SafetyInput {
  explicit SafetyInput(int joints) : q_wanted(VectorXd::Zero(joints)) {}
  VectorXd q_wanted;  ///< (n); NaN in an entry: its tracking is not checked (impedance control)
  double dt = 0.001;               ///< [s] measured time since the last update
  /// [s] age of the positions, since they were requested; if it has grown by dt, they are those of the last cycle
  double sensor_age = 0.0;
  double sensor_age_range = 0.0;   ///< [s] positions may be younger by this: the time until they arrived
  Eigen::Vector3d force{0, 0, 0};  ///< [N] measured at the tip, in the world
  double force_age = 0.0;          ///< [s] age of the force
  Eigen::Vector3d force_expected{0, 0, 0};  ///< MomentumObserver::force(); NaN: no comparison
  bool held = false;  ///< the controller holds the arm, which must come to rest as under kHold
};

/// One detected fault.
struct SafetyEvent {
  SafetyFault fault = SafetyFault::kNone;
  std::optional<JointIndex> joint = {};
  double after = 0.0;  ///< [s] time since the first fault
};

/// Checks the signals between controller and motors in every cycle. On a fault it takes over within the same
/// cycle with the action defined for the fault, and reports the reason. Checks continue during a fault: a later
/// fault with a stronger action takes over. Nothing allocates or throws after the constructor; the reason is an
/// enum with fixed texts.
///
///   safety.enable(); ... safety.activate();
///   tau = safety.update(state, input, tau);
///   if (safety.fault() != SafetyFault::kNone) log(describe(safety.fault()), safety.joint());
class SafetySupervisor {
 public:
  /// @throws InvalidInput  limits of wrong size, without order, or not above zero.
  SafetySupervisor(const Model& arm, const SafetyLimits& limits);

  // Transitions return false and change nothing if they are not allowed.
  bool enable() noexcept;    ///< kDisabled -> kReady
  bool home() noexcept;      ///< kReady -> kHoming
  bool homed() noexcept;     ///< kHoming -> kReady
  bool activate() noexcept;  ///< kReady, kHolding -> kActive
  bool hold() noexcept;      ///< kActive -> kHolding
  void disable() noexcept;   ///< any -> kDisabled; a fault remains
  bool reset() noexcept;     ///< kFault -> kDisabled

  /// @param tau  (n) torques of the controller. @returns (n) torques for the motors, always finite and within
  ///   limits.
  const VectorXd& update(const ArmState& arm, const SafetyInput& input,
                         const VectorRef& tau) noexcept;

  /// Sets the torque (n) in addition to the model's that holds the arm (ModelErrorObserver::torque()), for
  /// kFreeze and kHold; ignored once there is a fault. Entries that are not finite count as zero; at a fault
  /// each entry is limited as described at SafetyLimits::model_error.
  void set_holding_torque(const VectorRef& extra) noexcept;

  SafetyState state() const { return state_; }
  SafetyFault fault() const { return fault_; }
  SafetyAction action() const { return action_; }
  std::optional<JointIndex> joint() const { return joint_; }  ///< joint of the fault

  /// Faults in the order of detection, each kind once; [0] is the first.
  int events() const { return events_; }
  const SafetyEvent& event(int k) const { return event_[k]; }

 private:
  struct Finding {
    SafetyFault fault = SafetyFault::kNone;
    std::optional<JointIndex> joint = {};
  };
  Finding check(const ArmState& arm, const SafetyInput& input, const VectorRef& tau) noexcept;  ///< the first fault found
  Finding check_sensors(const ArmState& arm, const SafetyInput& input) const noexcept;  ///< values that are not finite, old samples
  Finding check_motion(const ArmState& arm, const SafetyInput& input) const noexcept;  ///< cycle time, and range, speed and tracking of each joint
  Finding check_motors(const ArmState& arm, const SafetyInput& input, const VectorRef& tau) noexcept;  ///< finite and not saturated for too long; adds to saturated_
  Finding check_force(const SafetyInput& input) noexcept;  ///< sensor, size and disagreement; adds to disagreed_
  Finding check_held(const ArmState& arm, const SafetyInput& input) noexcept;  ///< a fault of an arm that does not stop
  bool is_at_rest(const ArmState& arm) const noexcept;  ///< all joints are slower than rest_share of their limits
  void record_finding(const Finding& found) noexcept;  ///< one event per kind of fault
  void store_valid_state(const ArmState& arm, const SafetyInput& input) noexcept;  ///< positions, momentum and load, for kFreeze
  void keep_holding_torque() noexcept;  ///< limits extra_ and sets frozen_, at a fault
  void act(const ArmState& arm, const VectorRef& tau, double dt) noexcept;  ///< sets out_ by the action
  void brake(const ArmState& arm) noexcept;  ///< sets out_ to brake, then to hold

  SafetyLimits limits_;
  GravityCompensation gravity_;
  TorqueUncertainty uncertainty_;
  ArmState sound_;  // state at q_sound_, at rest
  SafetyState state_ = SafetyState::kDisabled;
  SafetyFault fault_ = SafetyFault::kNone;
  SafetyAction action_ = SafetyAction::kMotorsOff;
  std::optional<JointIndex> joint_ = {};
  bool seen_ = false;     // a valid position has been received
  bool stopped_ = false;  // while holding: q_hold_ is the position held
  double disagreed_ = 0.0;
  double frozen_for_ = 0.0;  // [s]
  double age_ = 0.0;          // [s] age of the positions in the previous cycle
  double since_sound_ = 0.0;  // [s] between the measurement of q_sound_ and that of the present positions
  double fault_for_ = 0.0;   // [s]
  bool watched_ = false;     // while held: energy_ is the reference of its kinetic energy
  double energy_ = 0.0, slow_for_ = 0.0;  // kinetic energy [J] when it was last stored; time [s] since then
  std::array<SafetyEvent, 16> event_;
  int events_ = 0;
  VectorXd saturated_;  // (n) [s]
  VectorXd q_sound_, q_hold_, frozen_, momentum_, extra_, extra_sound_, load_, rest_, y_, out_;
};

}  // namespace veridyn
