#include "veridyn/regressor/standard_parameters.hpp"

#include <array>
#include <cmath>

#include "math/numbers.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/math/require.hpp"
#include "model/inertial_names.hpp"

namespace veridyn {
namespace {

// Appends the parameters of effect e of the arm, a channel error, without values or bounds.
void append_channel_error(const Model& arm, const ChannelEffect& effect, int e,
                          std::vector<StandardParameter>& out) {
  const EffectTerm& term = arm.effects()[e];
  const std::vector<EffectParameter> own = effect.parameters();
  const bool metres = !term.axis.coefficients.isZero(0.0) && is_prismatic(arm, term.axis);
  for (size_t c = 0; c < own.size(); ++c) {
    StandardParameter p;
    p.name = term.effect + "(" + effect.place(arm, term) + ")." + own[c].name;
    p.unit = metres ? own[c].unit_prismatic : own[c].unit_revolute;
    p.component = static_cast<int>(c);
    p.effect = e;
    p.lower = -kInfinity;
    p.upper = kInfinity;
    out.push_back(p);
  }
}

}  // namespace

std::vector<StandardParameter> standard_parameters(const Model& arm) {
  std::vector<StandardParameter> out;
  for (size_t b = 0; b < arm.bodies().size(); ++b) {
    const Frame& frame = arm.frames()[arm.bodies()[b].value];
    for (int c = 0; c < kBodyParameters; ++c) {
      StandardParameter p;
      p.name = std::string(inertial_symbol(c)) + "_" + frame.name;
      p.unit = inertial_unit(c);
      p.body = static_cast<int>(b);
      p.component = c;
      p.fixed = frame.body->fixed;
      if (frame.body->phi) p.value = (*frame.body->phi)[c];
      p.lower = c == 0 ? 0.0 : -kInfinity;
      p.upper = kInfinity;
      out.push_back(p);
    }
  }
  for (size_t e = 0; e < arm.effects().size(); ++e) {
    if (const ChannelEffect* channel = channel_effect(arm.effects()[e].effect)) {
      append_channel_error(arm, *channel, static_cast<int>(e), out);
      continue;
    }
    const BoundEffect effect(arm, arm.effects()[e]);
    for (int c = 0; c < effect.parameter_count(); ++c) {
      StandardParameter p;
      p.name = effect.parameter_name(c);
      p.unit = effect.unit(c);
      p.component = c;
      p.effect = static_cast<int>(e);
      p.value = effect.values()[c];
      p.fixed = arm.effects()[e].fixed;
      p.lower = effect.parameters()[c].sign == ParameterSign::kNonnegative ? 0.0 : -kInfinity;
      p.upper = kInfinity;
      out.push_back(p);
    }
  }
  return out;
}

std::vector<std::string> parameter_names(const std::vector<StandardParameter>& parameters) {
  std::vector<std::string> names;
  for (const StandardParameter& p : parameters) names.push_back(p.name);
  return names;
}

Model with_values(const Model& arm, const VectorRef& values, const VectorRef& deviations) {
  const std::size_t count = standard_parameters(arm).size();
  require(static_cast<std::size_t>(values.size()) == count, "with_values: found ", values.size(), " values, expected ", count, ".");
  require(deviations.size() == 0 || deviations.size() == values.size(), "with_values: found ", deviations.size(),
          " deviations, expected ", count, " or none.");
  ModelDescription d = arm.description();
  d.identified.reset();
  const auto known = [&deviations](Eigen::Index i) {
    return deviations.size() > 0 && std::isfinite(deviations[i]);
  };
  Eigen::Index at = 0;
  for (const auto [k] : arm.bodies()) {
    Body& body = *d.frames[k].body;
    body.phi = values.segment<kBodyParameters>(at);
    body.std_phi.reset();
    if (deviations.size() > 0) body.std_phi = deviations.segment<kBodyParameters>(at);
    at += kBodyParameters;
  }
  for (EffectTerm& term : d.effects) {
    term.deviations.clear();
    for (const EffectParameter& p : find_axis_effect(term.effect).parameters()) {
      term.values[p.name] = values[at];
      if (known(at)) term.deviations[p.name] = deviations[at];
      ++at;
    }
  }
  return Model(d);
}

VectorXd standard_values(const Model& arm) {
  require(arm.inertial_values().has_value(), "'", arm.name(),
          "' has bodies without mass, com and inertia; what they are says how large an error is.");
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  VectorXd out(parameters.size());
  for (size_t k = 0; k < parameters.size(); ++k)
    out[static_cast<Eigen::Index>(k)] = parameters[k].value;
  return out;
}

MatrixXd full_regressor(const Model& arm, const VectorRef& q, const VectorRef& dq,
                        const VectorRef& ddq) {
  const MatrixXd bodies = torque_regressor(arm, q, dq, ddq);
  const std::vector<StandardParameter> parameters = standard_parameters(arm);
  MatrixXd Y = MatrixXd::Zero(arm.joints(), static_cast<Eigen::Index>(parameters.size()));
  Y.leftCols(bodies.cols()) = bodies;
  Eigen::Index at = bodies.cols();
  for (const EffectTerm& term : arm.effects()) {
    BoundEffect effect(arm, term);
    EffectColumns row{};
    effect.columns(effect.sample(0.0, q.data(), dq.data(), ddq.data(), 1), row);
    for (int c = 0; c < effect.parameter_count(); ++c)
      Y.col(at++) = row[c] * term.axis.coefficients;
  }
  return Y;
}

}  // namespace veridyn
