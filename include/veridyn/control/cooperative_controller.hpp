#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <optional>
#include <vector>

#include "veridyn/control/force_law.hpp"
#include "veridyn/control/passivity_monitor.hpp"
#include "veridyn/control/quintic_interpolator.hpp"
#include "veridyn/control/tether_guard.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

struct CooperativeOptions {
  std::vector<Eigen::Matrix3d> R_world_arm;  ///< axes of each arm's base; one entry for each arm
  int leader = 0;
  std::vector<CooperativeMember> members;
  double period = 1e-3;  ///< [s] interval between calls of update()

  // Bounds that end the task; every target is then held, see CooperativeState.
  double largest_force = 20.0;        ///< [N] reading of any member
  double largest_force_error = 20.0;  ///< [N] deviation of a reading from h_d
  double largest_age = 0.02;          ///< [s] age of a reading
  /// [m] deviation of any tip from its path, in addition to the stretch of its members under the wanted force
  /// where their stiffness is known
  double largest_error = 0.02;
  /// [N] largest change of a reading from one sample to the next, beyond twice the change that the
  /// member's length explains; checked where its stiffness is known.
  double jump_force = 1.0;
  /// [N] largest difference between the change of a reading and the change that the member's length implies, both
  /// since the wanted force last arrived; checked if the stiffness is known. The bound increases
  /// by `drift_length` [m] times the stiffness, by `drift_way` times the stiffness for each metre that an end
  /// has moved since, and by the effect of a stiffness that is wrong by the factor `drift_factor`.
  double drift_force = 0.5;
  double drift_length = 0.0005;
  double drift_way = 0.02;
  double drift_factor = 1.5;
  /// [N] change of force implied by a member's length while its samples stay equal to the last bit
  double stuck_force = 1.0;
  /// [J] largest energy that arms may feed into a member beyond the planned work
  /// (PassivityMonitor); an oscillating loop or a falling arm feeds more.
  double largest_energy = std::numeric_limits<double>::infinity();
  double stop_duration = 0.1;  ///< [s] duration of stopping the motion
  double relief_force = 5.0;   ///< [N] a reading beyond it makes the ends yield while targets are held
  double relief_gain = 0.02;   ///< [m/(N s)] speed of yielding per newton above relief_force
  double relief_speed = 0.2;   ///< [m/s] largest speed of yielding; ends do not yield if a sensor has failed
  /// True: a TetherGuard moves the other ends while targets are held, so that a falling arm does not jerk members.
  bool guard = true;
  TetherGuardOptions tether;  ///< options of the guard; its period is replaced by that of the controller
};

/// Measurements of one update(); sized by the controller's constructor.
struct CooperativeInput {
  CooperativeInput(int arms, int members)
      : position(static_cast<size_t>(arms), Eigen::Vector3d::Zero()),
        velocity(position),
        healthy(static_cast<size_t>(arms), 1),
        located(healthy),
        force(static_cast<size_t>(members)) {}
  std::vector<Eigen::Vector3d> position;  ///< [m] position of each tip in the world
  std::vector<Eigen::Vector3d> velocity;  ///< [m/s]
  std::vector<char> healthy;              ///< 0: this arm no longer follows its targets
  std::vector<char> located;  ///< 0: its position is unknown, and `position` holds an old value
  std::vector<ForceReading> force;        ///< reading of each member
};

/// Reference of a tip, in the world.
struct TipTarget {
  Eigen::Vector3d position{Eigen::Vector3d::Zero()};      ///< x_t of (7.11): x_d, corrected by the force [m]
  Eigen::Vector3d motion{Eigen::Vector3d::Zero()};  ///< x_d: reference of the motion alone [m]
  Eigen::Vector3d velocity{Eigen::Vector3d::Zero()};      ///< [m/s] derivative of x_d
  Eigen::Vector3d acceleration{Eigen::Vector3d::Zero()};  ///< [m/s^2] second derivative of x_d
  Eigen::Vector3d force{Eigen::Vector3d::Zero()};  ///< [N] wanted force of the tip on the object
  /// Displacement, velocity and acceleration by which the tip yields to a force while targets are held, else zero. The
  /// members above contain it; an arm that holds its measured position instead of the target adds it to that position.
  TetherGuard::Motion relief{};
};

/// kTracking, or the reason for which targets are held; only restart() leaves such a state.
enum class CooperativeState {
  kTracking,
  kForceTooLarge,
  /// A reading deviates from the wanted force by more than largest_force_error, for example if a member is slack.
  kForceMissed,
  kSensorStale,
  kSensorStuck,
  kSensorJumped,  ///< a reading changed by more than the member's length and stiffness explain
  kSensorDrifted,  ///< the same, over a longer time
  kArmLost,
  kTargetMissed,
  kEnergyMade,
  kNotFinite
};

/// Text such as "holds: a force sensor's samples are too old".
const char* describe(CooperativeState state);

/// Several arms move one object and control the forces in it (thesis 6.2 to 6.4 and 7.10 to 7.12,
/// with the errata). One arm is the leader: it follows the motion alone. The followers follow the
/// same motion of the object and correct the lengths of its members for the forces in them.
///
/// All quantities are in the world frame; commands are in the leader's axes, as in (6.2), and the
/// targets of an arm in its own base are R_world_arm' times these:
///
///   x_i      = p + R r_i            centroid p and orientation R of the object move, r_i is fixed
///                                   in the object (6.2, 6.3)
///   x_t,to   = x_to   + w  u x_f    u = (x_to - x_from) / |x_to - x_from| (7.10, 7.11)
///   x_t,from = x_from - w' u x_f    w = 1 for the only follower of the two ends, 1/2 where both are
///
/// Nothing allocates after the constructor; update() and the commands never throw.
///
///   CooperativeController control(options, tips);
///   control.set_force(0, 5.0, 1.0);  control.move({0, 0.01, 0}, 2.0);
///   every cycle:  const auto& targets = control.update(input);
class CooperativeController {
 public:
  /// @param tips  [m] where the arms hold the object now, in the world.
  /// @throws InvalidInput  no arm, a member between arms that do not exist or are the same, sizes
  /// that differ, numbers out of range.
  CooperativeController(const CooperativeOptions& options,
                        const std::vector<Eigen::Vector3d>& tips);

  // Commands return false and change nothing while targets are held, or if a number is out of range.

  /// Moves the object by `displacement` [m] in the leader's axes (6.2).
  bool move(const Eigen::Vector3d& displacement, double duration) noexcept;
  /// Rotates the object about its centroid (6.3) by Rz(gamma) Ry(beta) Rx(alpha) in the leader's axes. False
  /// during another rotation.
  bool rotate(const Eigen::Vector3d& alpha_beta_gamma, double duration) noexcept;
  /// Moves every follower by `by` [m] away from the centroid: (6.4), with the sign for which positive values pull.
  bool expand_grasp(double by, double duration) noexcept;
  /// Moves one arm relative to the object, for regrasping; in the world [m].
  bool move_arm(int arm, const Eigen::Vector3d& displacement, double duration) noexcept;
  /// Changes h_d of a member [N].
  bool set_force(int member, double force, double duration) noexcept;
  /// Switches the force control of a member on or off.
  bool track(int member, bool on) noexcept;
  /// Ends the motion and the change of forces: holds the present position and forces.
  void stop() noexcept;

  /// Clears the state that ended the task; targets start at the tips.
  void restart(const std::vector<Eigen::Vector3d>& tips) noexcept;

  /// Computes the targets of one cycle. Vectors have the sizes of the constructor; debug builds assert it.
  const std::vector<TipTarget>& update(const CooperativeInput& input) noexcept;

  CooperativeState state() const { return state_; }
  /// True if forces are unknown: each arm should then hold its position with a position loop. (An
  /// impedance with a wanted mass below the arm's own is many times stiffer without its sensor.)
  bool sensor_failed() const {
    return state_ == CooperativeState::kSensorStale || state_ == CooperativeState::kSensorStuck ||
           state_ == CooperativeState::kSensorJumped ||
           state_ == CooperativeState::kSensorDrifted ||
           state_ == CooperativeState::kNotFinite;
  }
  /// Rotation of the object since the start, and its rates.
  Eigen::Matrix3d rotation() const {
    return Eigen::AngleAxisd(angle_.x()[0], axis_).toRotationMatrix() * R_start_;
  }
  Eigen::Vector3d spin() const { return angle_.dx()[0] * axis_; }        ///< [rad/s], world
  Eigen::Vector3d spin_rate() const { return angle_.ddx()[0] * axis_; }  ///< [rad/s^2], world
  double relief_force() const { return options_.relief_force; }
  /// Sets relief_force [N], for example after a pretension was removed; values that are not above zero are ignored.
  void set_relief_force(double force) noexcept {
    if (force > 0.0) options_.relief_force = force;
  }
  bool arrived() const { return centre_.arrived() && angle_.arrived(); }  ///< the object's motion has ended
  double wanted_force(int member) const { return wanted_.x()[member]; }  ///< [N]
  double correction(int member) const { return trackers_[member].value(); }  ///< [m] x_f of a member
  int arms() const { return static_cast<int>(targets_.size()); }

 private:
  struct Watch {  // state of the checks on one sensor
    double force = 0.0, length = 0.0;
    std::optional<long> number;
    double last_force = 0.0, last_length = 0.0;  // values of the previous sample
    std::optional<long> last_number;
    double silent = 0.0;                         // [s] time since the start without any sample
    bool compared = false;  // true: the values below are those at the last arrival of the wanted force
    double sound_force = 0.0, sound_length = 0.0;
    Eigen::Vector3d from{Eigen::Vector3d::Zero()}, to{Eigen::Vector3d::Zero()};
  };

  void plan() noexcept;  ///< sets the targets to the object's motion
  void correct(const CooperativeInput& input) noexcept;  ///< adds the corrections of the force laws
  CooperativeState check_input(const CooperativeInput& input) noexcept;  ///< kTracking if no bound is exceeded
  void relieve(const CooperativeInput& input) noexcept;  ///< yields to forces above relief_force
  void give_way(const CooperativeInput& input) noexcept;  ///< follows a falling arm, then relieves members
  void update_lengths(const CooperativeInput& input) noexcept;  ///< updates the guard's unloaded lengths
  bool generates_energy(size_t member, const ForceReading& reading,
                    const CooperativeInput& input) noexcept;  ///< see kEnergyMade; advances the member's monitor
  bool is_stuck(size_t member, const ForceReading& reading, double length) noexcept;  ///< see kSensorStuck
  bool jumps(size_t member, const ForceReading& reading, double length) noexcept;  ///< see kSensorJumped
  bool drifts(size_t member, const ForceReading& reading, const CooperativeInput& input) noexcept;  ///< see kSensorDrifted
  bool commands_allowed() const { return state_ == CooperativeState::kTracking; }

  CooperativeOptions options_;
  std::vector<ForceTracker> trackers_;
  std::vector<char> tracked_;
  std::vector<Watch> watches_;
  std::vector<PassivityMonitor> monitors_;
  TetherGuard guard_;
  std::vector<TipTarget> targets_;
  QuinticInterpolator centre_, angle_, wanted_;
  std::vector<QuinticInterpolator> grips_;                // grasp points r_i
  std::vector<Eigen::Vector3d> relief_;  // [m] retreat of each tip in the world, while targets are held
  // orientation at the start of the current rotation
  Eigen::Matrix3d R_start_{Eigen::Matrix3d::Identity()};
  Eigen::Vector3d axis_{Eigen::Vector3d::UnitZ()};
  VectorXd scratch3_, scratch1_, goal_;
  bool arrived_ = false;  // the wanted forces had arrived in the previous cycle
  CooperativeState state_ = CooperativeState::kTracking;
};

}  // namespace veridyn
