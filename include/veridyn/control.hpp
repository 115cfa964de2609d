#pragma once

/// The face for controllers: reading a MODEL, undoing what it knows about the sensors, laws,
/// observers, limits. Each class says in its header what it computes, in which units, and what a
/// cycle must do; docs/control.md says which one gives what.
///
/// All vectors have an entry for each joint: [rad], [rad/s], [N m], or [m], [m/s], [N] where the joint
/// is prismatic. update() functions are noexcept and allocate nothing; their vectors have the size
/// that the constructor knew. Another size is a fault of the program: asserted in debug builds and
/// undefined in others, since a control loop neither throws nor allocates.

#include "veridyn/control/arm_state.hpp"
#include "veridyn/control/computed_torque.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/control/gravity_compensation.hpp"
#include "veridyn/control/impedance.hpp"
#include "veridyn/control/inverse_kinematics.hpp"
#include "veridyn/control/model_error_observer.hpp"
#include "veridyn/control/momentum_observer.hpp"
#include "veridyn/control/quintic_interpolator.hpp"
#include "veridyn/control/real_time.hpp"
#include "veridyn/control/safety_supervisor.hpp"
#include "veridyn/control/tip_kinematics.hpp"
#include "veridyn/control/torque_uncertainty.hpp"
#include "veridyn/control/velocity_observer.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/joint_sensors.hpp"
#include "veridyn/model/model_file.hpp"
