#pragma once

#include <memory>
#include <vector>

#include "veridyn/control/object_impedance.hpp"
#include "veridyn/cooperation/scenario.hpp"
#include "veridyn/simulation/world.hpp"

namespace veridyn {

/// A body of a scenario that arms hold, optionally with an impedance of its own.
class HeldObject {
 public:
  /// @param tips  [m] of all arms' tips at the start, as their controllers see them.
  HeldObject(const ScenarioBody& body, const std::vector<Eigen::Vector3d>& tips,
             const Eigen::Vector3d& gravity, double hand_stiffness);

  /// The body as the World takes it. @param tips  true [m]. @param held_by  where arms hold.
  static HeldBody in_world(const ScenarioBody& body, const std::vector<Eigen::Vector3d>& tips,
                           const std::vector<Attachment>& held_by);

  /// Replaces the targets of the arms that hold the body by those of its impedance, where it has
  /// one; the motion wanted of the body is that of the targets together.
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
