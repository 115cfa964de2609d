#include <cmath>

#include "phrase.hpp"
#include "registry.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {
namespace {

/// Effects of one parameter whose column is a function of the present motion, without a constant or a memory.
class OneColumn final : public AxisEffect, public WrittenInC {
 public:
  OneColumn(const char* name, EffectParameter parameter, EffectTraits traits, double (*column)(const AxisSample&) noexcept,
            const char* column_in_c, const char* phrase)
      : name_(name), parameter_(std::move(parameter)), traits_(traits), column_(column), column_in_c_(column_in_c), phrase_(phrase) {}

  std::string name() const override { return name_; }
  std::vector<EffectParameter> parameters() const override { return {parameter_}; }
  EffectTraits traits(const ShapeValues& /*shape*/) const override { return traits_; }
  void columns(const AxisSample& x, const ShapeValues& /*shape*/, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    row[0] = column_(x);
  }
  std::vector<std::string> c_columns(const ShapeValues& /*shape*/) const override { return {column_in_c_}; }

  /// The words with the parameter for `%`, and "force" or "torque" for `$`.
  std::string phrase(const std::vector<double>& values, const ShapeValues& /*shape*/, JointType type) const override {
    std::string out;
    for (const char c : std::string(phrase_))
      out += c == '%' ? parameter_text(*this, values, 0, type) : c == '$' ? effort_word(type) : std::string(1, c);
    return out;
  }

 private:
  const char* name_;
  EffectParameter parameter_;
  EffectTraits traits_;
  double (*column_)(const AxisSample&) noexcept;
  const char* column_in_c_;
  const char* phrase_;
};

}  // namespace

/// tau = inertia * dds: the motor's rotor and gears, reflected to the axis.
const Effect& rotor_inertia() {
  EffectTraits t;
  t.role = EffectRole::kInertia;
  t.uses_acceleration = true;
  t.affine = true;
  t.lasting = true;
  t.urdf_attribute = "armature";
  static const OneColumn kEffect("rotor_inertia", {"inertia", "kg m^2", "kg", ParameterSign::kNonnegative}, t,
                                 [](const AxisSample& x) noexcept { return x.dds; }, "dds", "% of reflected rotor inertia");
  return kEffect;
}

/// tau = coefficient * ds.
const Effect& viscous_friction() {
  EffectTraits t;
  t.role = EffectRole::kFriction;
  t.uses_velocity = true;
  t.affine = true;
  t.elementary = true;
  t.mixed_axes = true;
  t.urdf_attribute = "damping";
  static const OneColumn kEffect("viscous_friction", {"coefficient", "N m s/rad", "N s/m", ParameterSign::kNonnegative}, t,
                                 [](const AxisSample& x) noexcept { return x.ds; }, "ds", "% of viscous friction");
  return kEffect;
}

/// tau = coefficient * ds * |ds|: drag of a fluid, or of fans and churned grease, at high speed.
const Effect& quadratic_drag() {
  EffectTraits t;
  t.role = EffectRole::kFriction;
  t.uses_velocity = true;
  static const OneColumn kEffect("quadratic_drag", {"coefficient", "N m s^2/rad^2", "N s^2/m^2", ParameterSign::kNonnegative}, t,
                                 [](const AxisSample& x) noexcept { return x.ds * std::abs(x.ds); }, "ds * fabs(ds)",
                                 "% of drag that grows with the square of speed");
  return kEffect;
}

/// tau = offset: the zero of the torque measurement, or different friction in the two directions;
/// one recording of motion cannot separate the two (seed errata on thesis 4.13).
const Effect& torque_offset() {
  EffectTraits t;
  t.affine = true;
  t.holds_at_rest = true;
  t.elementary = true;
  t.urdf_attribute = "offset";
  static const OneColumn kEffect("torque_offset", {"offset", "N m", "N", ParameterSign::kAny}, t,
                                 [](const AxisSample&) noexcept { return 1.0; }, "1.0", "a constant $ of %");
  return kEffect;
}

}  // namespace veridyn
