#pragma once

#include <string>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// One file of C99 (which is C++ as well) that computes this arm's torques and needs nothing but
/// <math.h>. With NAME for the arm's name in letters, digits and underscores:
///
///   void NAME_inverse_dynamics(q, dq, ddq, tau)          tau[n] of the rigid bodies
///   void NAME_gravity(q, tau)                            tau[n] at rest
///   void NAME_mass_matrix(q, M)                          M[n][n]
///   void NAME_forward_dynamics(q, dq, tau, ddq)          ddq[n]
///   void NAME_derivatives(q, dq, ddq, by_q, by_dq)       [n][n] each, of inverse_dynamics
///   void NAME_regressor(q, dq, ddq, Y)                   Y[n][10 b], tau = Y * NAME_phi
///   void NAME_friction(q, dq, ddq, memory, tau)          tau[n] of friction and all other effects
///   void NAME_torque(q, dq, ddq, memory, tau)            the sum of the two
///
/// and constants NAME_joints, NAME_parameters, NAME_memory, NAME_phi, NAME_joint_names,
/// NAME_parameter_names. Numbers are doubles; in C, define NAME_real as float for floats; in C++
/// the functions are templates and take both. `memory` starts as zeros, one array for every
/// simulated or recorded arm; effects with memory see the states of successive calls. The
/// recursions are unrolled for the arm: products with a zero or a one of its geometry are omitted.
/// Below NAME_rest_speed (1e-4 rad/s or m/s unless it is defined beforehand) friction is proportional to the
/// velocity: choose it larger than the noise of a measured velocity to avoid chatter. Effects that depend on
/// time or describe measured motion are not included; a comment in the file lists them.
///
/// Compile the file, or include it in one place; with NAME_API defined as `static inline`
/// beforehand it may be included in many.
/// @throws InvalidInput  a body or an effect has no values.
std::string to_c_code(const Model& arm);

/// Writes to_c_code() to a file. @throws InvalidInput  the file cannot be written.
void save_c_code(const Model& arm, const std::string& path);

}  // namespace veridyn
