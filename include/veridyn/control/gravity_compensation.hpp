#pragma once

#include <vector>

#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

/// Computes torques that hold an arm at rest: gravity and the springs, offsets and cables of its model. They
/// serve hand guiding, and are a fallback after faults that disable everything else.
///
///   GravityCompensation hold(arm);
///   tau = hold.update(q);
class GravityCompensation {
 public:
  /// @throws InvalidInput  a body or an effect has no values.
  explicit GravityCompensation(const Model& arm);

  /// @param q  (n), true positions: see JointSensors. @returns tau (n), valid until the next update().
  /// Vectors have the sizes of the constructor; debug builds assert it.
  const VectorXd& update(const VectorRef& q) noexcept;

 private:
  RigidBodyDynamics dynamics_;
  std::vector<BoundEffect> forces_;
  VectorXd rest_, tau_;
};

}  // namespace veridyn
