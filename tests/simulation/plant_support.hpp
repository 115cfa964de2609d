#pragma once

#include <string>
#include <utility>
#include <vector>

#include "support/sample_arms.hpp"
#include "veridyn/model/model_file.hpp"
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
