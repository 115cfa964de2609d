#include "control/static_forces.hpp"

#include "veridyn/math/require.hpp"

namespace veridyn {

ControlPart control_part(const EffectTraits& traits) {
  const bool left_out = traits.depends_on_time || !traits.forward_simulable;
  if (left_out || traits.role == EffectRole::kSensor || traits.role == EffectRole::kArm) return ControlPart::kLeftOut;
  if (traits.role == EffectRole::kInertia) return ControlPart::kInertia;
  return traits.role == EffectRole::kFriction ? ControlPart::kFriction : ControlPart::kForce;
}

VectorXd control_parameters(const Model& arm, const char* where) {
  const auto phi = arm.inertial_values();
  require(phi.has_value(), where, ": arm '", arm.name(),
          "' has bodies without mass, com and inertia; identify it first.");
  return *phi;
}

std::vector<BoundEffect> static_forces(const Model& arm) {
  std::vector<BoundEffect> forces;
  for (const EffectTerm& term : arm.effects()) {
    BoundEffect effect(arm, term);
    if (control_part(effect.traits()) != ControlPart::kForce) continue;
    require(effect.has_values(), "control: effect ", effect.parameter_name(0), " of arm '",
            arm.name(), "' has no value; identify it first.");
    forces.push_back(std::move(effect));
  }
  return forces;
}

void add_forces(std::vector<BoundEffect>& forces, const VectorRef& q, const VectorRef& dq,
                const VectorRef& rest, VectorXd& tau) noexcept {
  for (BoundEffect& effect : forces) {
    const double force = effect.force(effect.sample(0.0, q.data(), dq.data(), rest.data(), 1));
    const VectorXd& c = effect.term().axis.coefficients;
    for (Eigen::Index i = 0; i < c.size(); ++i) tau[i] += c[i] * force;
  }
}

}  // namespace veridyn
