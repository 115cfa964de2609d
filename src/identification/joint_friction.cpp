#include "veridyn/identification/joint_friction.hpp"

#include <algorithm>

#include "effects/plain_friction.hpp"
#include "math/numbers.hpp"
#include "veridyn/effects/effect_facts.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/identification/base_parameters.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn {
namespace {

bool adds_friction(const Model& arm, JointFriction friction) {
  return friction == JointFriction::kPlain ||
         (friction == JointFriction::kAuto && has_no_friction(arm) &&
          arm.description().values == RobotValues::kPrior);
}

bool is_rotor(const EffectTerm& term) { return term.effect == kRotorInertia; }

// Adds to `plain` the rotor inertia of the joints where it is identifiable on its own.
Model with_identifiable_rotors(const Model& plain) {
  const Model all = with_effect_of_all_joints(plain, kRotorInertia);
  const BaseParameters base = identifiable_base_parameters(all);
  const std::vector<StandardParameter> parameters = standard_parameters(all);
  ModelDescription d = plain.description();
  for (size_t p = 0; p < parameters.size(); ++p) {
    const auto term = static_cast<size_t>(parameters[p].effect.value_or(0));
    const bool added = parameters[p].effect && term >= plain.effects().size();
    if (added && base.classes[p] == Identifiability::kAlone) d.effects.push_back(all.effects()[term]);
  }
  return Model(std::move(d));
}

}  // namespace

const char* name_of(JointFriction friction) {
  if (friction == JointFriction::kPlain) return "plain";
  return friction == JointFriction::kFile ? "file" : "auto";
}

Model with_friction_alone(const Model& arm, JointFriction friction) {
  return adds_friction(arm, friction) ? with_plain_friction(arm) : arm;
}

Model with_friction(const Model& arm, JointFriction friction) {
  return adds_friction(arm, friction) ? with_identifiable_rotors(with_plain_friction(arm)) : arm;
}

std::string friction_remark(const Model& file, const Model& arm) {
  if (!has_no_friction(file)) return "";
  if (has_no_friction(arm))
    return text("'", file.name(), "' has no friction, and every real joint has; friction `plain` "
                "identifies viscous and Coulomb friction and an offset of every joint.");
  std::vector<std::string> rotors;
  for (const EffectTerm& term : arm.effects()) {
    if (is_rotor(term))
      rotors.push_back(arm.coordinates()[main_coordinate(term.axis).value].name);
  }
  std::string with;
  for (size_t k = 0; k < rotors.size(); ++k) with += (k > 0 ? ", " : "") + rotors[k];
  return text("'", file.name(), "' has no friction: viscous and Coulomb friction and an offset of every "
              "joint", with.empty() ? "" : ", and the rotor inertia of " + with + ",",
              " are identified with it (friction `file` leaves them out).");
}

std::vector<JointNumber> plain_friction_of(const Model& arm) {
  std::vector<JointNumber> out;
  for (int i = 0; i < arm.joints(); ++i) {
    for (size_t e = 0; e < arm.effects().size(); ++e) {
      const EffectTerm& term = arm.effects()[e];
      const bool own = term.axis.coefficients == VectorXd::Unit(arm.joints(), i);
      if (!own || !has_axis_effect(term.effect)) continue;
      const EffectFacts bound(arm, term);
      if (!bound.traits().elementary && !is_rotor(term)) continue;
      for (int p = 0; p < bound.parameter_count(); ++p) {
        const std::string& name = bound.parameters()[p].name;
        const auto deviation = term.deviations.find(name);
        out.push_back({term.effect, name, bound.unit(p), {i}, bound.values()[p],
                       deviation == term.deviations.end() ? kNaN : deviation->second});
      }
    }
  }
  return out;
}

}  // namespace veridyn
