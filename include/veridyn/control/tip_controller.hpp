#pragma once

#include <optional>

#include "veridyn/control/control_cycle.hpp"
#include "veridyn/control/cooperative_controller.hpp"
#include "veridyn/control/impedance.hpp"

namespace veridyn {

/// Converts a target in the world to a reference of the tip in the base of its arm.
inline TaskReference in_base(const TipTarget& target, const Eigen::Vector3d& p_world_base,
                             const Eigen::Matrix3d& R_world_base = Eigen::Matrix3d::Identity()) noexcept {
  TaskReference out;
  out.x.head<3>() = R_world_base.transpose() * (target.position - p_world_base);
  out.dx.head<3>() = R_world_base.transpose() * target.velocity;
  out.ddx.head<3>() = R_world_base.transpose() * target.acceleration;
  return out;
}

/// Impedance of the tip, see ImpedanceGains; one number for all directions, or six.
struct TipControllerOptions {
  Gain mass = 2.0;         ///< M_d [kg], [kg m^2], above zero
  Gain damping = 80.0;     ///< K_d [N s/m], [N m s/rad]
  Gain stiffness = 800.0;  ///< K_p [N/m], [N m/rad]
  Tip tip{};               ///< controlled point; without a frame that of default_tip()
  ImpedanceOptions impedance{};
  CycleOptions cycle{};
};

/// Computes the torques of the drives from encoder positions, a force sensor if there is one, and a reference
/// of the tip, every cycle: a ControlCycle around Impedance. The arm may leave its reference, so that the
/// supervisor does not compare the two.
///
///   TipController controller(arm, {2, 100, 100});
///   TaskReference wanted = controller.reference_at(measured);
///   every cycle: robot.write(controller.update(measured, wanted, 1e-3));
///
/// Nothing allocates, throws or blocks after the constructor; one object serves one thread.
class TipController {
 public:
  /// @throws InvalidInput  as ControlCycle and Impedance.
  explicit TipController(const Model& arm, const TipControllerOptions& options = {});

  /// @param measured  signals as measured by the sensors; `wrench` is zero without a force sensor. @param
  /// reference  coordinates of the tip, see AnalyticalTask.
  /// @param dt  [s] since the previous update, as measured. @returns (n) torques in the scale of the drives
  /// [N m], [N], always finite and within limits; valid until the next update().
  const VectorXd& update(const Measured& measured, const TaskReference& reference, double dt) noexcept {
    measure(measured, dt);
    return act(reference);
  }
  /// update() in two steps, for a reference that depends on the present state.
  const ArmState& measure(const Measured& measured, double dt) noexcept {
    return cycle_.measure(measured, dt);
  }
  const VectorXd& act(const TaskReference& reference) noexcept;

  /// A reference at rest at these measured positions. Allocates.
  TaskReference reference_at(const Measured& measured) const;

  /// Gains of the next update(); false for gains that the constructor would refuse.
  bool set_gains(const ImpedanceGains& gains) noexcept { return impedance_.set_gains(gains); }
  /// Calls ControlCycle::set_sent_torques().
  void set_sent_torques(const VectorRef& drive_torques) noexcept { cycle_.set_sent_torques(drive_torques); }

  bool hold() noexcept { return cycle_.hold(); }   ///< see ControlCycle::hold()
  void limp() noexcept { cycle_.limp(); }          ///< gravity compensation and a little damping, until resume()
  void resume() noexcept { cycle_.resume(); }      ///< ends both; the reference must begin at the arm's position
  void reset() noexcept { cycle_.reset(); }        ///< clears a fault and all observers

  std::optional<ControllerFault> fault() const noexcept { return cycle_.fault(); }
  int joints() const { return cycle_.joints(); }
  const ControlCycle& cycle() const { return cycle_; }
  const ArmState& state() const { return cycle_.state(); }  ///< evaluated at true positions
  const TipKinematics& tip() const { return state().tip(); }

 private:
  TipController(const Model& arm, const Tip& tip, const TipControllerOptions& options);

  ControlCycle cycle_;
  Impedance impedance_;
};

}  // namespace veridyn
