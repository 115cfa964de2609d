#include "known_effects.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "veridyn/effects/effect_facts.hpp"

namespace veridyn {
namespace {

// The force at one state along the axis, with unloaded memory.
double force_at(const EffectFacts& effect, double s, double ds, double dds) {
  AxisSample x;
  x.s = s;
  x.ds = ds;
  x.dds = dds;
  return effect.force_at(x);
}

// The effect as a simple force, determined from its traits; all zero if it cannot be one.
SimpleForce simple_force(const EffectFacts& effect) {
  SimpleForce out;
  out.axis = effect.term().axis;
  const EffectTraits& traits = effect.traits();
  if (traits.uses_source || traits.uses_load || traits.depends_on_time || traits.memory) return out;
  if (traits.affine) {
    // s = c . q + s0 is measured from the spring's own zero here, so that the axis' offset becomes part of
    // the spring.
    const double s0 = out.axis.offset;
    out.offset = force_at(effect, s0, 0.0, 0.0);
    out.stiffness = force_at(effect, s0 + 1.0, 0.0, 0.0) - out.offset;
    out.damping = force_at(effect, s0, 1.0, 0.0) - out.offset;
    out.inertia = force_at(effect, s0, 0.0, 1.0) - out.offset;
  } else if (traits.dry == DryFriction::kConstant) {
    out.friction = force_at(effect, 0.0, 1.0, 0.0);
  }
  return out;
}

bool is_zero_force(const SimpleForce& f) {
  return f.offset == 0.0 && f.stiffness == 0.0 && f.damping == 0.0 && f.inertia == 0.0 &&
         f.friction == 0.0;
}

// True for effects that simulators refuse; a fit without bounds can give such values.
bool has_negative_value(const SimpleForce& f) {
  return f.stiffness < 0.0 || f.damping < 0.0 || f.inertia < 0.0 || f.friction < 0.0;
}

// True if a simulator's joint elements can represent the effect.
bool can_be_written(const EffectFacts& effect) {
  const EffectTraits& t = effect.traits();
  const bool own = !t.uses_source && !t.uses_load && !t.depends_on_time && !t.memory;
  return own && (t.affine || t.dry == DryFriction::kConstant);
}

}  // namespace

PlacedEffects placed_effects(const std::vector<SimpleForce>& forces, int joints) {
  PlacedEffects out{std::vector<SimpleForce>(static_cast<std::size_t>(joints)), {},
                    VectorXd::Zero(joints)};
  for (SimpleForce f : forces) {
    const VectorXd c = f.axis.coefficients;
    if (f.stiffness == 0.0) out.constants += std::exchange(f.offset, 0.0) * c;
    Eigen::Index i = 0;
    c.cwiseAbs().maxCoeff(&i);
    const double s = c[i];
    if (c.cwiseAbs().sum() != std::abs(s)) {
      out.across.push_back(f);
      continue;
    }
    SimpleForce& sum = out.along[i];
    sum.offset += f.offset * s;
    sum.stiffness += f.stiffness * s * s;
    sum.damping += f.damping * s * s;
    sum.inertia += f.inertia * s * s;
    sum.friction += f.friction * std::abs(s);
  }
  return out;
}

KnownEffects known_effects(const Model& arm) {
  KnownEffects out;
  for (const EffectTerm& term : arm.arm_effects()) out.left_out.push_back(term.effect + " on the arm");
  for (const EffectTerm& term : arm.effects()) {
    const EffectFacts effect(arm, term);
    if (!effect.has_values() || !can_be_written(effect)) {
      out.left_out.push_back(term.effect + " on " + axis_text(arm, term.axis) +
                             (effect.has_values() ? "" : ", whose values are not known"));
      continue;
    }
    const SimpleForce force = simple_force(effect);
    if (has_negative_value(force)) {
      out.left_out.push_back(term.effect + " on " + axis_text(arm, term.axis) + ", which is below zero");
      continue;
    }
    if (is_zero_force(force)) continue;
    const auto same = std::find_if(out.forces.begin(), out.forces.end(), [&](const SimpleForce& f) {
      return f.axis.coefficients == force.axis.coefficients;
    });
    if (same == out.forces.end()) {
      out.forces.push_back(force);
      continue;
    }
    same->offset += force.offset;
    same->stiffness += force.stiffness;
    same->damping += force.damping;
    same->inertia += force.inertia;
    same->friction += force.friction;
  }
  return out;
}

}  // namespace veridyn
