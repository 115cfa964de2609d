#pragma once

/// Includes everything that a controller needs: reading of an identified model, JointController and
/// TipController (complete control loops), and their components for custom loops: sensor correction, control
/// laws, observers, limits. Each class documents its equations and units; docs/control.md gives an overview.
///
/// All vectors have an entry for each joint: [rad], [rad/s], [N m], or [m], [m/s], [N] where the
/// joint is prismatic. update() functions are noexcept and allocate nothing; their vectors must
/// have the sizes of the constructor. Debug builds assert this; another size is undefined in
/// release builds, since a control loop neither throws nor allocates.

#include "veridyn/control/arm_state.hpp"
#include "veridyn/control/computed_torque.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/control/gravity_compensation.hpp"
#include "veridyn/control/impedance.hpp"
#include "veridyn/control/inverse_kinematics.hpp"
#include "veridyn/control/joint_controller.hpp"
#include "veridyn/control/model_error_observer.hpp"
#include "veridyn/control/momentum_observer.hpp"
#include "veridyn/control/quintic_interpolator.hpp"
#include "veridyn/control/real_time.hpp"
#include "veridyn/control/safety_supervisor.hpp"
#include "veridyn/control/tip_controller.hpp"
#include "veridyn/control/tip_kinematics.hpp"
#include "veridyn/control/torque_uncertainty.hpp"
#include "veridyn/control/velocity_observer.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/joint_sensors.hpp"
#include "veridyn/files/model_file.hpp"
