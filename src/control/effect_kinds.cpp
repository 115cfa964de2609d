#include "control/effect_kinds.hpp"

#include <map>

#include "veridyn/math/require.hpp"

namespace veridyn {

EffectKind effect_kind(const std::string& effect) {
  using K = EffectKind;
  static const std::map<std::string, K> kKinds = {{"rotor_inertia", K::kInertia},
                                                  {"joint_spring", K::kForce},
                                                  {"viscous_friction", K::kFriction},
                                                  {"coulomb_friction", K::kFriction},
                                                  {"torque_offset", K::kForce},
                                                  {"stribeck_friction", K::kFriction},
                                                  {"presliding_hysteresis", K::kFriction},
                                                  {"asymmetric_friction", K::kFriction},
                                                  {"position_dependent_friction", K::kFriction},
                                                  {"position_dependent_viscosity", K::kFriction},
                                                  {"load_dependent_friction", K::kFriction},
                                                  {"quadratic_drag", K::kFriction},
                                                  {"sublinear_viscous", K::kFriction},
                                                  {"torque_ripple", K::kForce},
                                                  {"cable_coupling", K::kForce},
                                                  {"position_force", K::kForce},
                                                  {"backlash", K::kFriction},
                                                  {"transmission_compliance", K::kLeftOut},
                                                  {"torque_drift", K::kLeftOut},
                                                  {"warm_up", K::kLeftOut}};
  const auto found = kKinds.find(effect);
  require(found != kKinds.end(), "control: found the effect '", effect,
          "', which has no place in control.");
  return found->second;
}

}  // namespace veridyn
