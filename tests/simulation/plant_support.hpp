#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "support/sample_arms.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plant.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn {

/// The arm with these effects instead of its own.
inline Model with_effects(const Model& arm, std::vector<EffectTerm> effects) {
  ModelDescription description = arm.description();
  description.effects = std::move(effects);
  return Model(std::move(description));
}

inline EffectTerm effect(const Model& arm, const std::string& name, int joint,
                         std::map<std::string, double> values) {
  EffectTerm term;
  term.effect = name;
  term.axis.coefficients = VectorXd::Unit(arm.joints(), joint);
  term.values = std::move(values);
  return term;
}

/// A slide along the horizontal x of the world; the mass is that of its random body.
inline Model slide() {
  ArmBuilder arm("slide", 1, 21);
  arm.description().coordinates[0].prismatic = true;
  arm.link(-1, JointType::kPrismatic, {1.0}, 0.0, {rotation_y(M_PI / 2), {0, 0, 0}},
           identity_pose());
  return arm.build();
}

/// A torque of two frequencies at each of n joints [N m].
inline VectorXd swinging_torque(int n, double t) {
  VectorXd tau(n);
  for (int i = 0; i < n; ++i) tau[i] = std::sin((3.0 + i) * t + i) + 0.5 * std::sin(11.0 * t);
  return tau;
}

inline double mass_of(const Model& arm) {
  return (*arm.inertial_values())[0];
}

inline Model robot(const std::string& name) {
  return plausible_model(read_model(name), 1).arm;
}

inline VectorXd one(double value) {
  return VectorXd::Constant(1, value);
}

}  // namespace veridyn
