#include "contact_memory.hpp"
#include "phrase.hpp"
#include "registry.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {
namespace {

/// Friction that depends on the position, by its distance from a centre:
///
///   tau = motion * (slope * (s - centre) + curvature * (s - centre)^2)
class PositionDependent : public AxisEffect, public WrittenInC {
 public:
  std::vector<EffectShape> shapes() const override {
    EffectShape centre{"centre", "rad", "m", 0.0, -10.0, 10.0, false, false};
    centre.scale = ShapeScale::kMiddle;
    return {centre};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.role = EffectRole::kFriction;
    t.uses_position = true;
    t.uses_velocity = true;
    t.depends_on_position = true;
    return t;
  }
  void columns(const AxisSample& x, const ShapeValues& shape, EffectState& state,
               EffectColumns& row) const noexcept final {
    const double way = x.s - shape[0];
    const double of_motion = motion(x, shape, state);
    row[0] = of_motion * way;
    row[1] = of_motion * way * way;
  }
  std::vector<std::string> c_columns(const ShapeValues& shape) const final {
    const std::string way = "(s - " + c_number(shape[0]) + ")";
    const std::string of_motion = c_motion(shape);
    return {of_motion + " * " + way, of_motion + " * " + way + " * " + way};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& shape, JointType type) const final {
    return std::string(kind()) + " that changes with position, by " + parameter_text(*this, values, 0, type) +
           " and " + parameter_text(*this, values, 1, type) + " from " + shape_text(*this, shape, 0, type);
  }

 private:
  virtual const char* kind() const = 0;
  virtual double motion(const AxisSample& x, const ShapeValues& shape, EffectState& state) const noexcept = 0;
  virtual std::string c_motion(const ShapeValues& shape) const = 0;
};

/// The motion is its sign. The level at the centre is coulomb_friction. The sign is sliding_direction(), or with `distance`
/// in the file the contact memory of presliding_hysteresis, which is valid at rest too; use the
/// distance found there. On an arm whose gravity torque varies with s it is confounded with
/// load_dependent_friction. Source: thesis 5.6, "a change in friction based on the joint position".
class PositionDependentFriction final : public PositionDependent {
 public:
  std::string name() const override { return "position_dependent_friction"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"slope", "N m/rad", "N/m", ParameterSign::kAny},
            {"curvature", "N m/rad^2", "N/m^2", ParameterSign::kAny}};
  }
  std::vector<EffectShape> shapes() const override {
    std::vector<EffectShape> out = PositionDependent::shapes();
    out.push_back({"distance", "rad", "m", 0.0, 1e-5, 1.0, true, false});
    return out;
  }
  EffectTraits traits(const ShapeValues& shape) const override {
    EffectTraits t = PositionDependent::traits(shape);
    t.uses_velocity = shape[1] == 0.0;
    t.memory = shape[1] > 0.0;
    t.dry = t.memory ? DryFriction::kNone : DryFriction::kVarying;
    return t;
  }
  std::string c_before(const ShapeValues& shape) const override {
    return shape[1] > 0.0 ? c_friction_direction(shape[1]) + ";" : "";
  }

 private:
  const char* kind() const override { return "friction"; }
  double motion(const AxisSample& x, const ShapeValues& shape, EffectState& state) const noexcept override {
    return friction_direction(x, shape[1], state);
  }
  std::string c_motion(const ShapeValues& shape) const override {
    return shape[1] > 0.0 ? "z[0]" : c_friction_direction(0.0);
  }
};

/// The motion is the velocity. The coefficient at the centre is viscous_friction. Bending hoses and harnesses cause it; the
/// inertia's cross terms in dq_i dq_j have other columns and are not confounded with it while one
/// joint moves alone.
class PositionDependentViscosity final : public PositionDependent {
 public:
  std::string name() const override { return "position_dependent_viscosity"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"slope", "N m s/rad^2", "N s/m^2", ParameterSign::kAny},
            {"curvature", "N m s/rad^3", "N s/m^3", ParameterSign::kAny}};
  }

 private:
  const char* kind() const override { return "viscous friction"; }
  double motion(const AxisSample& x, const ShapeValues& /*shape*/, EffectState& /*state*/) const noexcept override { return x.ds; }
  std::string c_motion(const ShapeValues& /*shape*/) const override { return "ds"; }
};

}  // namespace

const Effect& position_dependent_friction() {
  static const PositionDependentFriction kEffect;
  return kEffect;
}

const Effect& position_dependent_viscosity() {
  static const PositionDependentViscosity kEffect;
  return kEffect;
}

}  // namespace veridyn
