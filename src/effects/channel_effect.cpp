#include "veridyn/effects/channel_effect.hpp"

#include <utility>

#include "veridyn/math/require.hpp"

namespace veridyn {

std::vector<RigidColumn> ChannelEffect::rigid_columns(const Model& /*arm*/, std::optional<JointIndex> /*joint*/) const {
  return {};
}

std::string ChannelEffect::place(const Model& arm, const EffectTerm& term) const {
  const bool of_arm = whole_arm() || !channel_joint(*this, term);
  if (of_arm) return "arm";
  return axis_text(arm, term.axis) + (term.from ? " from " + axis_text(arm, *term.from) : "");
}

void SensorError::apply(ModelDescription& arm, std::optional<JointIndex> joint, std::optional<JointIndex> from,
                        const std::vector<double>& values) const {
  for (size_t i = 0; i < arm.coordinates.size(); ++i) {
    if (!joint || static_cast<int>(i) == joint->value)
      add_to_channel(arm.coordinates[i].recorded, from, values);
  }
}

EffectTraits ArmEffect::traits(const ShapeValues& /*shape*/) const {
  EffectTraits t;
  t.role = EffectRole::kArm;
  t.depends_on_position = true;
  t.lasting = true;
  return t;
}

EffectTerm& ArmEffect::term_of(ModelDescription& arm) const {
  for (EffectTerm& term : arm.arm_effects) {
    if (term.effect == name()) return term;
  }
  EffectTerm term;
  term.effect = name();
  term.axis.coefficients = VectorXd::Zero(arm.coordinates.size());
  for (const EffectParameter& p : parameters()) term.values[p.name] = 0.0;
  arm.arm_effects.push_back(std::move(term));
  return arm.arm_effects.back();
}

namespace {

// The effect of the term; throws InvalidInput if it is none of the whole arm.
const ArmEffect& arm_effect(const Model& arm, const EffectTerm& term) {
  const auto* effect = dynamic_cast<const ArmEffect*>(channel_effect(term.effect));
  require(effect != nullptr, "arm '", arm.name(), "': '", term.effect,
          "' stands among the effects of the whole arm, and is none.");
  return *effect;
}

// The term's values in the order of parameters(); throws InvalidInput if one is missing.
std::vector<double> values_of(const ArmEffect& effect, const EffectTerm& term) {
  std::vector<double> out;
  for (const EffectParameter& p : effect.parameters()) {
    const auto value = term.values.find(p.name);
    require(value != term.values.end(), "effect '", term.effect, "' has no value for ", p.name, ".");
    out.push_back(value->second);
  }
  return out;
}

}  // namespace

MatrixXd arm_effect_torques(const Model& arm, const TorqueRegressor& bodies, const MatrixXd& q,
                            const MatrixXd& dq, const MatrixXd& ddq, double dt) {
  const auto phi = arm.inertial_values();
  if (arm.arm_effects().empty() || !phi) return {};
  MatrixXd effort;
  bodies.torques(q, dq, ddq, *phi, effort);
  const ChannelMotion motion{arm, bodies, *phi, q, dq, ddq, effort, dt};
  MatrixXd out = MatrixXd::Zero(q.rows(), q.cols());
  for (const EffectTerm& term : arm.arm_effects()) {
    const ArmEffect& effect = arm_effect(arm, term);
    const std::vector<double> values = values_of(effect, term);
    const std::vector<MatrixXd> columns = effect.columns(motion, std::nullopt);
    for (size_t p = 0; p < columns.size(); ++p) out += values[p] * columns[p];
  }
  return out;
}

Model with_arm_states(const Model& arm) {
  ModelDescription out = arm.description();
  const std::vector<EffectTerm> terms = std::move(out.arm_effects);
  out.arm_effects.clear();
  std::vector<EffectTerm> without_states;
  for (const EffectTerm& term : terms) {
    const ArmEffect& effect = arm_effect(arm, term);
    const size_t before = out.coordinates.size();
    out = effect.with_states(out, values_of(effect, term));
    if (out.coordinates.size() == before) without_states.push_back(term);
  }
  out.arm_effects = std::move(without_states);
  for (EffectTerm& term : out.arm_effects)
    term.axis.coefficients = VectorXd::Zero(out.coordinates.size());
  return Model(std::move(out));
}

std::optional<JointIndex> channel_joint(const ChannelEffect& effect, const EffectTerm& term) {
  if (effect.can_be_common() && term.axis.coefficients.isZero(0.0)) return std::nullopt;
  return main_coordinate(term.axis);
}

std::optional<JointIndex> channel_source(const EffectTerm& term) {
  if (!term.from) return std::nullopt;
  return main_coordinate(*term.from);
}

Model with_channel_error(const Model& arm, const EffectTerm& term,
                         const std::vector<double>& values) {
  const ChannelEffect* effect = channel_effect(term.effect);
  require(effect != nullptr, "with_channel_error: '", term.effect, "' is not a channel error.");
  ModelDescription out = arm.description();
  effect->apply(out, channel_joint(*effect, term), channel_source(term), values);
  return Model(std::move(out));
}

}  // namespace veridyn
