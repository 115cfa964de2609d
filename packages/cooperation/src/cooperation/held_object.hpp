#pragma once

#include <memory>
#include <vector>

#include "veridyn/control/object_impedance.hpp"
#include "veridyn/cooperation/scenario.hpp"
#include "veridyn/simulation/world.hpp"

namespace veridyn {

/// A body of a scenario that arms hold, optionally with its own impedance.
class HeldObject {
 public:
  /// @param tips  [m] initial positions of all arms' tips, as their controllers measure them. @param gravity
  /// [m/s^2] in the world. @param hand_stiffness  [N/m] of the arms' impedances.
  HeldObject(const ScenarioBody& body, const std::vector<Eigen::Vector3d>& tips,
             const Eigen::Vector3d& gravity, double hand_stiffness);

  /// The body in the form that World needs. @param tips  true [m]. @param held_by  points at which arms hold
  /// it.
  static HeldBody in_world(const ScenarioBody& body, const std::vector<Eigen::Vector3d>& tips,
                           const std::vector<Attachment>& held_by);

  /// If the body has an impedance, replaces the targets of the arms that hold it by those of the impedance;
  /// the wanted motion of the body is the common motion of the targets.
  void update(const CooperativeController& motion, const CooperativeInput& input,
              std::vector<TipTarget>& targets) noexcept;

  const ScenarioBody& scenario() const { return body_; }
  /// Reference of the body's centre [m].
  const Eigen::Vector3d& wanted() const { return wanted_.position; }

 private:
  ScenarioBody body_;
  double hand_stiffness_;
  std::unique_ptr<ObjectImpedance> impedance_;
  std::vector<Eigen::Vector3d> positions_, velocities_;
  ObjectMotion wanted_;
};

}  // namespace veridyn
