#include "veridyn/control/gravity_compensation.hpp"

#include <cassert>

#include "control/static_forces.hpp"

namespace veridyn {

GravityCompensation::GravityCompensation(const Model& arm)
    : dynamics_(arm, control_parameters(arm, "GravityCompensation")),
      forces_(static_forces(arm)),
      rest_(VectorXd::Zero(arm.joints())),
      tau_(rest_) {}

const VectorXd& GravityCompensation::update(const VectorRef& q) noexcept {
  assert(q.size() == tau_.size());
  dynamics_.gravity_torques(q, tau_);
  add_forces(forces_, q, rest_, rest_, tau_);
  return tau_;
}

}  // namespace veridyn
