#pragma once

#include <vector>

#include "veridyn/control/arm_state.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

enum class FrictionRule {
  /// Friction of the velocity, nothing within its deadband.
  kVelocity,
  /// Thesis 5.6.1 and listing 7.5.1 with the errata: the same, and within the velocity deadband the
  /// friction at rest in the direction of the position error, once that exceeds its own deadband.
  kStickSlip,
  /// Friction with a memory by its state along the measured path, the rest in the direction in
  /// which motion is wanted, without jumps.
  kPresliding,
  /// No compensation but the best guess of what friction does now, for observers: memories by their
  /// state, the rest in the direction of the measured velocity, in proportion within its deadband.
  kMeasured
};

/// Deadbands of turning and of sliding axes.
struct Deadband {
  double revolute;   ///< [rad/s], [rad]
  double prismatic;  ///< [m/s], [m]
};

struct FrictionOptions {
  FrictionRule rule = FrictionRule::kStickSlip;
  Deadband velocity{0.01, 0.005};     ///< as in the thesis
  Deadband position{0.0015, 0.0003};  ///< as in the thesis for sliding; it has none for turning
  /// Of the identified friction, how much is compensated: the least that the real one is believed
  /// to be. Compensation above the real friction makes the arm move by itself.
  double share = 0.8;
  /// The energy that compensation may put into an axis beyond what the wanted motion asks for:
  /// friction at rest times this way [rad], [m]. Infinite: no supervision.
  Deadband tank_capacity{0.02, 0.002};
};

/// Torque against the friction that a model has identified, by the effects' own classes.
///
/// Terms along one axis c . q are one friction. Its force while sliding is that of the terms at the
/// present position, memories fully sheared in the direction of motion; a wanted velocity that is
/// faster in the direction of motion replaces the measured one (listing 7.5.1, both directions).
///
/// Supervision: compensation acts along the measured motion and so feeds energy into it. Each axis
/// has an energy tank: work of the compensation empties it, wanted motion fills it at the rate that
/// friction at rest would cost, up to `tank_capacity`. Compensation fades out with the last tenth
/// of the tank, so that unwanted motion cannot go on: it costs the content of one tank at most,
/// however wrong the identified friction is.
///
///   FrictionCompensation friction(arm);
///   every cycle: tau += friction.update(state, wanted.dq, error, 0.001);  // stored vectors
class FrictionCompensation {
 public:
  /// @throws InvalidInput  a friction effect has no values; an option that cannot be.
  explicit FrictionCompensation(const Model& arm, const FrictionOptions& options = {});

  /// @param dq_wanted  (n) of the interpolator.
  /// @param error  (n) wanted minus measured position of the joints; in Cartesian control
  ///               Impedance::joint_error().
  /// @param dt  [s] since the last update().
  /// @returns (n), valid until the next update(); to be added to the torque. Zero, and nothing is
  ///          remembered, where the arm's state is NaN or infinite.
  /// Sizes are those of the constructor; another one is a fault of the program, asserted in debug
  /// builds alone.
  const VectorXd& update(const ArmState& arm, const VectorXd& dq_wanted, const VectorXd& error,
                         double dt) noexcept;

  /// Forgets memories and fills the tanks.
  void reset() noexcept;

  int axes() const { return static_cast<int>(axes_.size()); }
  const VectorXd& axis(int k) const { return axes_[static_cast<size_t>(k)].c; }

  bool prismatic(int k) const { return axes_[static_cast<size_t>(k)].prismatic; }
  double share() const { return options_.share; }

  /// Scales one axis' friction, see AdaptiveFriction. Between 0 and 2; others are refused: false.
  bool set_scale(int k, double scale) noexcept;
  double scale(int k) const { return axes_[static_cast<size_t>(k)].scale; }

  /// Force along axis k of the identified friction sliding at `speed` in direction +-1, share and
  /// scale left aside, where the arm stood at the last update().
  double sliding(int k, double direction, double speed) const noexcept;

  /// Content of the energy tank of axis k as a share of its capacity, 0 to 1.
  double tank_level(int k) const noexcept;

 private:
  struct Axis {
    VectorXd c;
    double offset = 0.0;
    bool prismatic = false;
    std::vector<BoundEffect> terms;
    double velocity_deadband = 0.0, position_deadband = 0.0, tank_capacity = 0.0;
    double scale = 1.0;
    double energy = 0.0;   // content of the tank [J]
    double largest = 0.0;  // capacity of the tank [J]
    double s = 0.0, load = 0.0;
    double before = 0.0;  // s at the last update
    double force = 0.0;   // force since that update [N m], [N]
    bool first = true;
  };
  static double sliding(const Axis& axis, double direction, double speed) noexcept;
  static double tank_level(const Axis& axis) noexcept;
  double by_velocity(const Axis& axis, double v, double v_wanted, double error) const noexcept;
  static double by_memory(Axis& axis, double will, double speed, double v) noexcept;
  double whole(Axis& axis, double v, double v_wanted, double error) const noexcept;
  void supervise(Axis& axis, double v_wanted, double dt) const noexcept;

  FrictionOptions options_;
  std::vector<Axis> axes_;
  VectorXd tau_;
};

}  // namespace veridyn
