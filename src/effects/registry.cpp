#include "registry.hpp"

#include "veridyn/effects/effect.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"

namespace veridyn {

const std::vector<const Effect*>& all_effects() {
  static const std::vector<const Effect*> kAll = {
      &rotor_inertia(),
      &joint_spring(),
      &viscous_friction(),
      &coulomb_friction(),
      &torque_offset(),
      &stribeck_friction(),
      &presliding_hysteresis(),
      &asymmetric_friction(),
      &position_dependent_friction(),
      &position_dependent_viscosity(),
      &load_dependent_friction(),
      &quadratic_drag(),
      &sublinear_viscous(),
      &torque_ripple(),
      &cable_coupling(),
      &position_force(),
      &backlash(),
      &transmission_compliance(),
      &torque_drift(),
      &warm_up(),
  };
  return kAll;
}

bool has_effect(const std::string& name) {
  for (const Effect* e : all_effects()) {
    if (e->name() == name) return true;
  }
  return false;
}

const Effect& find_effect(const std::string& name) {
  for (const Effect* e : all_effects()) {
    if (e->name() == name) return *e;
  }
  std::vector<std::string> names;
  for (const Effect* e : all_effects()) names.push_back(e->name());
  throw InvalidInput(text("effect '", name, "' cannot act along an axis of a model",
                          did_you_mean(name, names), "; these can: ", listed(names), "."));
}

}  // namespace veridyn
