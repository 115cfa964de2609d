#pragma once

#include <array>

#include "veridyn/control/arm_state.hpp"
#include "veridyn/control/gravity_compensation.hpp"
#include "veridyn/control/torque_uncertainty.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

enum class SafetyState {
  kDisabled,  ///< motors off
  kHoming,    ///< the controller moves, slowly
  kReady,     ///< stands still, waits
  kActive,    ///< the controller moves
  kHolding,   ///< stands still on command, may go on
  kFault      ///< the safe action of the fault, until reset()
};

/// Why. The first check that fails is the fault: sensors first, then motors, motion, force.
enum class SafetyFault {
  kNone,
  kNotFinite,    ///< a position, a velocity or a time is NaN or infinite
  kSensorAge,    ///< positions are older than allowed
  kEncoderJump,  ///< a position moved farther in one cycle than the joint can
  kController,   ///< its torque is NaN or infinite
  kOverrun,      ///< a cycle took longer than allowed
  kPosition,     ///< beyond a limit, or too fast to stop before it
  kVelocity,
  kTracking,    ///< too far from where it should be
  kTorque,      ///< asks for more than the motor has, for too long
  kForce,       ///< more than allowed at the tip
  kForceSensor,  ///< the force is NaN or infinite, older than allowed, or disagrees with the
                 ///< joints' torques
  kNotHeld  ///< It is held and does not come to rest, or after a fault it is faster than `runaway`
            ///< allows
};

/// What the motors do.
enum class SafetyAction {
  kMotorsOff,  ///< zero torque (and brakes, where the arm has them)
  kPass,       ///< the controller's torque, within the motors' limits
  kHold,       ///< brakes with the model's help, then stays where it stopped
  kRelease,    ///< gravity and damping alone: gives way to what presses
  kFreeze      ///< the torque that held the arm at its last sound position and, fading with
               ///< `braking`, most of what stops its last sound momentum; no feedback.
               ///< For arms that are counterbalanced; others need their brakes
};

/// Fixed words: "position limit".
const char* describe(SafetyState state) noexcept;
const char* describe(SafetyFault fault) noexcept;
const char* describe(SafetyAction action) noexcept;

/// The action of a fault: kMotorsOff for an arm that is not held, kFreeze where positions cannot be
/// trusted, kRelease for forces, kHold for all others. Of several faults the one with the strongest
/// action counts, in this order.
SafetyAction action_of(SafetyFault fault) noexcept;

struct SafetyLimits {
  VectorXd lower, upper;              ///< (n) [rad], [m]
  VectorXd velocity;                  ///< (n)
  VectorXd torque;                    ///< (n) of the motors
  VectorXd tracking;                  ///< (n) wanted minus measured position
  double force = 15.0;                ///< [N] at the tip
  double force_disagreement = 6.0;    ///< [N] between sensor and MomentumObserver
  double disagreement_seconds = 0.1;  ///< [s] for which it must last
  double sensor_age = 0.003;          ///< [s] of positions
  double force_age = 0.01;            ///< [s] of the force
  double overrun = 0.005;             ///< [s] between two updates
  double torque_seconds = 0.2;        ///< [s] for which the motors may be saturated
  double homing_share = 0.2;          ///< Share of the velocity limit while homing
  double braking = 30.0;              ///< [1/s]: braking is -braking dq; stops within dq / braking
  /// [s] in which the kinetic energy of a held arm must fall to a half. Braking alone takes
  /// ln 2 / (2 braking) = 12 ms; a motor at its limit takes longer.
  double held_seconds = 0.1;
  /// Share of the velocity limits below which a held arm is at rest: its place is kept from there on,
  /// by a spring that a torque beside the model moves by a hundredth of its acceleration.
  double rest_share = 0.05;
  double runaway = 1.5;      ///< times the velocity limit: motors off, where a fault is there already
  /// Of every parameter, UncertaintyOptions::relative: a holding torque leaves the model by no more
  /// than TorqueUncertainty at rest and the measured force explain.
  double model_error = 0.1;
};

/// Position and velocity limits of the robot file; its effort limits where it gives any, else
/// `torque` for every joint; a tracking error of 5 % of the range.
SafetyLimits safety_limits(const Model& arm, double torque);

/// What the supervisor is told in a cycle beside the arm's state.
struct SafetyInput {
  explicit SafetyInput(int joints) : q_wanted(VectorXd::Zero(joints)) {}
  VectorXd q_wanted;               ///< (n); NaN in an entry: not tracked (impedance control)
  double dt = 0.001;               ///< [s] since the last update, as it was
  double sensor_age = 0.0;         ///< [s] of the positions
  Eigen::Vector3d force{0, 0, 0};  ///< [N] measured at the tip, in the world
  double force_age = 0.0;          ///< [s] of it
  Eigen::Vector3d force_expected{0, 0, 0};  ///< MomentumObserver::force(); NaN: not compared
  bool held = false;  ///< the controller holds the arm, which must come to rest as under kHold
};

/// One fault that was found.
struct SafetyEvent {
  SafetyFault fault = SafetyFault::kNone;
  int joint = -1;
  double after = 0.0;  ///< [s] since the first fault
};

/// Stands between controller and motors: checks every cycle, and on a fault takes over within that
/// cycle with an action that is defined for it, and says why. Checks go on in a fault: a later one
/// with a stronger action takes over. Nothing allocates or throws after the constructor; the reason
/// is an enum with fixed words.
///
///   safety.enable(); ... safety.activate();
///   tau = safety.update(state, input, tau);
///   if (safety.fault() != SafetyFault::kNone) log(describe(safety.fault()), safety.joint());
class SafetySupervisor {
 public:
  /// @throws InvalidInput  limits of wrong size, without order, or not above zero.
  SafetySupervisor(const Model& arm, const SafetyLimits& limits);

  // Transitions; false, and nothing changes, where one is not allowed.
  bool enable() noexcept;    ///< kDisabled -> kReady
  bool home() noexcept;      ///< kReady -> kHoming
  bool homed() noexcept;     ///< kHoming -> kReady
  bool activate() noexcept;  ///< kReady, kHolding -> kActive
  bool hold() noexcept;      ///< kActive -> kHolding
  void disable() noexcept;   ///< any -> kDisabled, but a fault stays
  bool reset() noexcept;     ///< kFault -> kDisabled

  /// @param tau  (n) of the controller. @returns (n) what the motors shall do, always finite and
  /// within limits.
  const VectorXd& update(const ArmState& arm, const SafetyInput& input,
                         const VectorXd& tau) noexcept;

  /// The torque beyond the model that holds the arm (ModelErrorObserver::torque()), (n): kept for
  /// kFreeze and kHold, and no longer taken once there is a fault. Entries that are not
  /// finite are taken for zero; at a fault each is brought within what SafetyLimits::model_error and
  /// the measured force explain.
  void set_holding_torque(const VectorXd& extra) noexcept;

  SafetyState state() const { return state_; }
  SafetyFault fault() const { return fault_; }
  SafetyAction action() const { return action_; }
  int joint() const { return joint_; }  ///< Joint of the fault, from 0; -1: none in particular

  /// Faults in the order in which they were found, each kind once; [0] is the first.
  int events() const { return events_; }
  const SafetyEvent& event(int k) const { return event_[static_cast<std::size_t>(k)]; }

 private:
  struct Finding {
    SafetyFault fault = SafetyFault::kNone;
    int joint = -1;
  };
  Finding check(const ArmState& arm, const SafetyInput& input, const VectorXd& tau) noexcept;
  Finding check_sensors(const ArmState& arm, const SafetyInput& input) const noexcept;
  Finding check_motion(const ArmState& arm, const SafetyInput& input) const noexcept;
  Finding check_motors(const SafetyInput& input, const VectorXd& tau) noexcept;
  Finding check_force(const SafetyInput& input) noexcept;
  Finding check_held(const ArmState& arm, const SafetyInput& input) noexcept;
  bool rests(const ArmState& arm) const noexcept;
  void note(const Finding& found) noexcept;
  void trust(const ArmState& arm, const SafetyInput& input) noexcept;
  void keep_holding_torque() noexcept;
  void act(const ArmState& arm, const VectorXd& tau, double dt) noexcept;
  void brake(const ArmState& arm) noexcept;

  SafetyLimits limits_;
  GravityCompensation gravity_;
  TorqueUncertainty uncertainty_;
  ArmState sound_;  // at q_sound_, at rest
  SafetyState state_ = SafetyState::kDisabled;
  SafetyFault fault_ = SafetyFault::kNone;
  SafetyAction action_ = SafetyAction::kMotorsOff;
  int joint_ = -1;
  bool seen_ = false;     // a sound position
  bool stopped_ = false;  // while holding: q_hold_ is where
  double disagreed_ = 0.0;
  double frozen_for_ = 0.0;  // [s]
  double fault_for_ = 0.0;   // [s]
  bool watched_ = false;     // while held: its energy is compared with
  double energy_ = 0.0, slow_for_ = 0.0;  // [J], since [s]
  std::array<SafetyEvent, 16> event_;
  int events_ = 0;
  VectorXd saturated_;  // (n) [s]
  VectorXd q_sound_, q_hold_, frozen_, momentum_, extra_, extra_sound_, load_, rest_, y_, out_;
};

}  // namespace veridyn
