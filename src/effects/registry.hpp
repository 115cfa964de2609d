#pragma once

#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/effects/effect.hpp"

namespace veridyn {

// One line per effect; each function is defined in the file of its name.
const Effect& rotor_inertia();
const Effect& joint_spring();
const Effect& viscous_friction();
const Effect& coulomb_friction();
const Effect& torque_offset();
const Effect& stribeck_friction();
const Effect& presliding_hysteresis();
const Effect& asymmetric_friction();
const Effect& position_dependent_friction();
const Effect& position_dependent_viscosity();
const Effect& load_dependent_friction();
const Effect& quadratic_drag();
const Effect& sublinear_viscous();
const Effect& torque_ripple();
const Effect& cable_coupling();
const Effect& position_force();
const Effect& backlash();
const Effect& transmission_compliance();
const Effect& torque_gain();
const Effect& torque_drift();
const Effect& time_delay();
const Effect& gravity_tilt();
const Effect& encoder_offset();
const Effect& warm_up();
const Effect& base_compliance();
const Effect& tabulated_force();
const Effect& end_stop();
const Effect& tip_force();
const Effect& torque_crosstalk();

}  // namespace veridyn
