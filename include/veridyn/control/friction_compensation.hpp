#pragma once

#include <vector>

#include "veridyn/control/arm_state.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/kinematics/links.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

enum class FrictionRule {
  /// Friction in the direction of the wanted velocity; none within the velocity deadband.
  kVelocity,
  /// Like kVelocity, and within the velocity deadband the friction at rest in the direction of the position
  /// error if that exceeds its own deadband: thesis 5.6.1 and listing 7.5.1 with the errata.
  kStickSlip,
  /// Friction with memory is computed from its state along the measured path; other friction acts in the
  /// direction of the wanted motion, without jumps.
  kPresliding,
  /// The best estimate of the present friction, for observers and not for compensation: friction with memory is
  /// computed from its state, other friction in the direction of the measured velocity, linear within its deadband.
  kMeasured
};

/// Deadbands of revolute and of prismatic axes.
struct Deadband {
  double revolute;   ///< [rad/s], [rad]
  double prismatic;  ///< [m/s], [m]
};

struct FrictionOptions {
  FrictionRule rule = FrictionRule::kStickSlip;
  Deadband velocity{0.01, 0.005};  ///< value of the thesis
  /// The prismatic value is that of the thesis, which has none for revolute axes.
  Deadband position{0.0015, 0.0003};
  /// Share of the identified friction that is compensated: a lower bound of the real friction.
  /// Compensation above the real friction makes the arm move by itself.
  double share = 0.8;
  /// Energy that compensation may feed into an axis beyond the work of the wanted motion: friction
  /// at rest times this distance [rad], [m]. Infinite: no supervision.
  Deadband tank_capacity{0.02, 0.002};
};

/// Compensates the identified friction of a model, according to the classes of its effects.
///
/// All friction terms along one axis c . q are compensated as one force. Its sliding value is that of the terms
/// at the present position, with memories fully sheared in the direction of motion. The speed is the measured
/// one or, if it is larger in this direction, the wanted one (listing 7.5.1, both directions).
///
/// Supervision: compensation acts along the measured motion and so feeds energy into it. Each axis has an
/// energy tank: the work of the compensation empties it, wanted motion fills it at the power of the friction
/// at rest, up to `tank_capacity`. Compensation fades out over the last tenth of the tank, so that unwanted
/// motion ends: its energy is at most the content of one tank, however wrong the identified friction is.
///
///   FrictionCompensation friction(arm);
///   every cycle: tau += friction.update(state, wanted.dq, error, 0.001);  // stored vectors
class FrictionCompensation {
 public:
  /// @throws InvalidInput  a friction effect has no values, or an option is out of range.
  explicit FrictionCompensation(const Model& arm, const FrictionOptions& options = {});

  /// @param dq_wanted  (n) velocity of the reference.
  /// @param error  (n) wanted minus measured position of the joints; in Cartesian control
  ///               Impedance::joint_error().
  /// @param dt  [s] since the last update().
  /// @returns (n), valid until the next update(); to be added to the torque. Zero, without a change of state,
  /// if the arm's state is NaN or infinite.
  /// Vectors have the sizes of the constructor; debug builds assert it.
  const VectorXd& update(const ArmState& arm, const VectorRef& dq_wanted, const VectorRef& error,
                         double dt) noexcept;

  /// Sets position and load of the axes for sliding() alone; memories and tanks are unchanged.
  void set_axis_states(const ArmState& arm) noexcept;

  /// Clears the memories and fills the tanks.
  void reset() noexcept;

  int axes() const { return static_cast<int>(axes_.size()); }
  const VectorXd& axis(int k) const { return axes_[k].c; }
  /// The nonzero coefficients of the axis.
  const std::vector<JointCoefficient>& terms(int k) const { return axes_[k].along; }

  bool prismatic(int k) const { return axes_[k].prismatic; }
  double share() const { return options_.share; }

  /// Scales the friction of one axis, see AdaptiveFriction. Returns false unless the scale times the
  /// share is in 0 .. 2.
  bool set_scale(int k, double scale) noexcept;
  double scale(int k) const { return axes_[k].scale; }

  /// Sliding force of the identified friction along axis k at `speed` in direction +-1, without
  /// share and scale, at the position of the last update() or set_axis_states().
  double sliding(int k, double direction, double speed) const noexcept;

  /// Compensation along axis k at the last update() [N m], [N].
  double force(int k) const { return axes_[k].force; }

  /// Content of the energy tank of axis k as a share of its capacity, 0 to 1.
  double tank_level(int k) const noexcept;

 private:
  struct Axis {
    VectorXd c;
    std::vector<JointCoefficient> along;  // nonzero entries of c
    double offset = 0.0;
    double squared = 0.0;  // |c|^2
    bool prismatic = false;
    bool loaded = false;    // a term depends on the load
    bool constant = true;   // the friction depends on neither position nor load
    std::vector<BoundEffect> terms;
    double velocity_deadband = 0.0, position_deadband = 0.0, tank_capacity = 0.0;
    double scale = 1.0;
    double at_rest = 0.0;  // larger sliding force at rest of the two directions, if constant
    double energy = 0.0;   // content of the tank [J]
    double largest = 0.0;  // capacity of the tank [J]
    double s = 0.0, load = 0.0;
    double before = 0.0;  // s at the previous update
    double force = 0.0;   // force since that update [N m], [N]
    bool first = true;
  };
  static double sliding(const Axis& axis, double direction, double speed) noexcept;  ///< [N m], [N] friction while sliding, as the public sliding()
  static double rest_force(const Axis& axis) noexcept;  ///< larger magnitude of both directions
  static double tank_level(const Axis& axis) noexcept;  ///< content relative to capacity; 1 without supervision
  double velocity_force(const Axis& axis, double v, double v_wanted, double error) const noexcept;  ///< rules by velocity; position error only at rest
  static double memory_force(Axis& axis, double will, double speed, double v) noexcept;  ///< advances memories; other terms slide at `speed`, by share `will`, -1 to 1
  double total_force(Axis& axis, double v, double v_wanted, double error) const noexcept;  ///< [N m], [N] compensation of all terms, before it is scaled
  void supervise(Axis& axis, double v_wanted, double dt) const noexcept;  ///< fills and drains the tank

  FrictionOptions options_;
  std::vector<Axis> axes_;
  VectorXd tau_;
};

}  // namespace veridyn
