#include "contact_memory.hpp"
#include "phrase.hpp"
#include "registry.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {
namespace {

/// tau = level * z: friction with a memory z in [-1, 1] of the path since the last reversal, see
/// advance_contact().
///
/// After a reversal out of full sliding, z = 1 - 2 (1 - exp(-path / distance)) in the previous
/// direction. Far beyond `distance` it is Coulomb friction; at rest it keeps its value. Several
/// memories on one axis, each with its distance, are several terms. Noise of s draws z towards
/// zero: smooth the position first.
///
/// It is passive: from z it returns at most level * distance * (|z| - ln(1 + |z|)), less than was
/// stored. Source: Dahl 1968, as in thesis 5.6 (z there), without the speed-dependent terms of its
/// generalisations.
class PreslidingHysteresis final : public AxisEffect, public WrittenInC {
 public:
  std::string name() const override { return "presliding_hysteresis"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"level", "N m", "N", ParameterSign::kNonnegative}};
  }
  std::vector<EffectShape> shapes() const override {
    EffectShape distance{"distance", "rad", "m", 5e-3, 1e-5, 1.0, true, true, 1.5e-4};
    distance.scale = ShapeScale::kTravel;
    distance.grid = {3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.25};
    return {distance};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.role = EffectRole::kFriction;
    t.uses_position = true;
    t.memory = true;
    t.slow = true;
    t.mixed_axes = true;
    return t;
  }
  void columns(const AxisSample& x, const ShapeValues& shape, EffectState& state,
               EffectColumns& row) const noexcept override {
    row[0] = advance_contact(x.s, shape[0], state);
  }
  std::vector<std::string> c_columns(const ShapeValues& shape) const override {
    return {"@contact(s, " + c_number(shape[0]) + ", z)"};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& shape,
                     JointType type) const override {
    return parameter_text(*this, values, 0, type) +
           " of friction with memory: after a reversal it builds up over " +
           shape_text(*this, shape, 0, type);
  }
};

}  // namespace

const Effect& presliding_hysteresis() {
  static const PreslidingHysteresis kEffect;
  return kEffect;
}

}  // namespace veridyn
