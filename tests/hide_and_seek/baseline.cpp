#include "hide_and_seek/baseline.hpp"

#include <optional>

#include "veridyn/effects/effect.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::seek {
namespace {

constexpr double kWorth = 0.02;  // share of the joint's sum of squares that an effect must take away
constexpr double kNormal = 1.96;  // standard deviations of a 95 % interval

Identification fitted(const Model& robot, const std::vector<std::string>& train, int threads) {
  IdentificationOptions options;
  options.method = Method::kOls;
  options.friction = veridyn::JointFriction::kFile;
  options.threads = threads;
  return identify(robot, train, {}, options);
}

Model with_effect(const Model& robot, const std::string& effect, int joint) {
  ModelDescription d = robot.description();
  EffectTerm term;
  term.effect = effect;
  term.axis = {VectorXd::Unit(robot.joints(), joint), 0.0};
  d.effects.push_back(term);
  return Model(std::move(d));
}

bool carries(const Model& robot, const std::string& effect, int joint) {
  for (const EffectTerm& term : robot.effects()) {
    if (term.effect == effect && term.axis.coefficients == VectorXd::Unit(robot.joints(), joint))
      return true;
  }
  return false;
}

}  // namespace

std::vector<NamedFinding> named_by_least_squares(const Model& robot,
                                                 const std::vector<std::string>& train,
                                                 int threads) {
  const VectorXd error = fitted(robot, train, threads).train_error.relative;
  require(error.size() == robot.joints(), robot.name(),
          ": least squares has no errors of its joints.");
  double most = kWorth;
  std::optional<Identification> best;
  NamedFinding finding;
  for (const AxisEffect* effect : axis_effects()) {
    const EffectTraits traits = effect->traits();
    if (traits.uses_source || traits.uses_load || traits.tabulated) continue;
    for (int joint = 0; joint < robot.joints(); ++joint) {
      if (carries(robot, effect->name(), joint)) continue;
      Identification fit = fitted(with_effect(robot, effect->name(), joint), train, threads);
      if (!fit.model || fit.train_error.relative.size() != robot.joints()) continue;
      const double left = fit.train_error.relative[joint] / error[joint];
      if (!(1.0 - left * left > most)) continue;
      most = 1.0 - left * left;
      finding.effect = effect->name();
      finding.joint = joint + 1;
      best = std::move(fit);
    }
  }
  if (!best) return {};
  const EffectTerm& term = best->model->effects().back();
  for (const auto& [name, deviation] : term.deviations) {
    const double value = term.values.at(name);
    finding.parameters.push_back(
        {name, "", value, value - kNormal * deviation, value + kNormal * deviation});
  }
  return {finding};
}

}  // namespace veridyn::seek
