#include "control/static_forces.hpp"

#include "control/effect_kinds.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {

VectorXd control_parameters(const Model& arm, const char* where) {
  const auto phi = arm.inertial_values();
  require(phi.has_value(), where, ": arm '", arm.name(),
          "' has bodies without mass, com and inertia; identify it first.");
  return *phi;
}

std::vector<BoundEffect> static_forces(const Model& arm) {
  std::vector<BoundEffect> forces;
  for (const EffectTerm& term : arm.effects()) {
    if (effect_kind(term.effect) != EffectKind::kForce) continue;
    BoundEffect effect(arm, term);
    require(effect.has_values(), "control: effect ", effect.parameter_name(0), " of arm '",
            arm.name(), "' has no value; identify it first.");
    forces.push_back(std::move(effect));
  }
  return forces;
}

void add_forces(std::vector<BoundEffect>& forces, const VectorXd& q, const VectorXd& dq,
                const VectorXd& rest, VectorXd& tau) noexcept {
  for (BoundEffect& effect : forces) {
    const double force = effect.force(effect.sample(0.0, q.data(), dq.data(), rest.data(), 1));
    const VectorXd& c = effect.term().axis.coefficients;
    for (Eigen::Index i = 0; i < c.size(); ++i) tau[i] += c[i] * force;
  }
}

}  // namespace veridyn
