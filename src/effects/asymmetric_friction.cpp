#include <cmath>

#include "phrase.hpp"
#include "registry.hpp"
#include "sliding_direction.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {
namespace {

/// Friction that differs between the two directions; each parameter is the forward minus the
/// backward value:
///
///   tau = level_difference * |sign(ds)| / 2 + viscous_difference * |ds| / 2
///
/// with the sign of sliding_direction(). The mean of both directions is coulomb_friction and
/// viscous_friction.
///
/// Identifiability: |ds| is a column of its own. |sign(ds)| is 1 whenever the joint moves, a
/// constant, and so confounded with torque_offset; only samples at rest, where it is 0, separate
/// the two. Recordings without rest determine only their sum, offset + level_difference / 2.
/// Source: thesis (4.13) and its errata.
class AsymmetricFriction final : public AxisEffect, public WrittenInC {
 public:
  std::string name() const override { return "asymmetric_friction"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"level_difference", "N m", "N", ParameterSign::kAny},
            {"viscous_difference", "N m s/rad", "N s/m", ParameterSign::kAny}};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.role = EffectRole::kFriction;
    t.uses_velocity = true;
    t.dry = DryFriction::kVarying;
    return t;
  }
  void columns(const AxisSample& x, const ShapeValues& /*shape*/, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    row[0] = 0.5 * std::abs(sliding_direction(x.ds));
    row[1] = 0.5 * std::abs(x.ds);
  }
  std::vector<std::string> c_columns(const ShapeValues& /*shape*/) const override {
    return {"0.5 * fabs(@direction(ds))", "0.5 * fabs(ds)"};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& /*shape*/,
                     JointType type) const override {
    return "friction that differs by direction, forwards minus backwards: " +
           parameter_text(*this, values, 0, type) + " and " +
           parameter_text(*this, values, 1, type);
  }
};

}  // namespace

const Effect& asymmetric_friction() {
  static const AsymmetricFriction kEffect;
  return kEffect;
}

}  // namespace veridyn
