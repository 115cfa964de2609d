#pragma once

#include <string>
#include <vector>

#include "veridyn/effects/effect.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Errors that are no force along an axis: they change what the whole model predicts, or how a
/// recording shows it. Their columns are derivatives of the torque that the arm's own values ask
/// for, so they are right to first order and only for an arm with values:
///
///   torque_gain     recorded = (1 + error) * true                 of one joint
///   time_delay      recorded(t) = true(t - seconds)               of one joint's torque
///   encoder_offset  recorded = true + offset                      of one joint's position; every
///                                                                 joint feels it
///   gravity_tilt    the base stands turned, R = Ry(pitch) Rx(roll)
bool is_arm_effect(const std::string& name);

/// The parameters of one of them.
const std::vector<EffectParameter>& arm_effect_parameters(const std::string& name);

/// "torque_gain(yaw).error", "gravity_tilt(arm).roll".
std::string arm_effect_parameter_name(const Model& arm, const EffectTerm& term, int p);

/// True if joint i has a column of it.
bool arm_effect_acts_on(const EffectTerm& term, int joint);

/// What was found, as Effect::phrase().
std::string arm_effect_phrase(const Model& arm, const EffectTerm& term,
                              const std::vector<double>& values);

/// The arm with the error in it: its recorded channel or its gravity.
Model with_arm_effect(const Model& arm, const EffectTerm& term, const std::vector<double>& values);

/// Gravity in a base that is turned by small angles, the change only [m/s^2].
Eigen::Vector3d tilted_gravity_change(const Eigen::Vector3d& gravity, double roll, double pitch);

}  // namespace veridyn
