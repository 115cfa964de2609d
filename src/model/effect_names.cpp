#include "model/effect_names.hpp"

namespace veridyn {

const std::vector<std::string>& effect_names() {
  static const std::vector<std::string> names{
      "rotor_inertia",
      "joint_spring",
      "viscous_friction",
      "coulomb_friction",
      "torque_offset",
      "stribeck_friction",
      "presliding_hysteresis",
      "asymmetric_friction",
      "position_dependent_friction",
      "position_dependent_viscosity",
      "load_dependent_friction",
      "quadratic_drag",
      "sublinear_viscous",
      "torque_ripple",
      "cable_coupling",
      "position_force",
      "backlash",
      "transmission_compliance",
      "torque_gain",
      "torque_drift",
      "time_delay",
      "payload",
      "gravity_tilt",
      "encoder_offset",
      "coupling_error",
      "external_contact",
      "warm_up",
  };
  return names;
}

const std::vector<std::string>& effect_keys() {
  static const std::vector<std::string> keys{"effect",      "axis",  "offset", "from",
                                             "from_offset", "frame", "values", "std"};
  return keys;
}

bool may_lack_axis(const std::string& effect) {
  return effect == "gravity_tilt" || effect == "coupling_error";
}

bool has_offset_parameter(const std::string& effect) {
  return effect == "torque_offset";
}

}  // namespace veridyn
