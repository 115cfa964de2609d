#pragma once

#include <vector>

#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

/// The torques that hold an arm where it is: gravity and the springs, offsets and cables of its
/// model. For hand guiding, and as the last thing left when a fault takes everything else away.
///
///   GravityCompensation hold(arm);
///   tau = hold.update(q);
class GravityCompensation {
 public:
  /// @throws InvalidInput  a body or an effect has no values.
  explicit GravityCompensation(const Model& arm);

  /// @param q  (n), true positions: see JointSensors. @returns tau (n), valid until the next update().
  /// Sizes are those of the constructor; another one is a fault of the program, asserted in debug
  /// builds alone.
  const VectorXd& update(const VectorXd& q) noexcept;

 private:
  RigidBodyDynamics dynamics_;
  std::vector<BoundEffect> forces_;
  VectorXd rest_, tau_;
};

}  // namespace veridyn
