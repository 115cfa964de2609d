#include "diagnosis/findings/right_to_a_name.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "diagnosis/evidence/numerics.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/effects/effect.hpp"

namespace veridyn {
namespace {

// Parameters in which the torque is linear; shape constants are never nothing.
bool is_size(const std::string& effect, const std::string& name) {
  if (!has_effect(effect)) return false;
  for (const EffectParameter& p : find_effect(effect).parameters()) {
    if (name == p.name || name.rfind(p.name + "_", 0) == 0) return true;
  }
  return false;
}

double largest_torque(const Identification& fitted, int joint) {
  double out = 0.0;
  for (const CompressedRecording& r : fitted.factors) {
    const TorqueFacts& facts = r.joints[joint];
    out = std::max({out, std::abs(facts.minimum), std::abs(facts.maximum)});
  }
  return out;
}

// How much larger the mean square error of a joint is, over its standard error between the parts.
double worse_by_standard_errors(const VectorXd& before, const VectorXd& after) {
  const auto count = static_cast<double>(before.size());
  if (count < 2.0) return 0.0;
  const VectorXd differences = after - before;
  const double mean = differences.mean();
  const double square = (differences.array() - mean).square().sum();
  return mean / std::max(std::sqrt(square / (count * (count - 1.0))), numerics::kTiny);
}

double own_gain(const Finding& f, int joint) {
  if (f.folds_before.size() <= joint || f.folds_after.size() <= joint) return 0.0;
  return f.folds_before[joint] - f.folds_after[joint];
}

// The finding with the smallest gain on a joint, or the one that costs it most.
std::optional<size_t> least_needed(const Diagnosis& d, size_t first, const std::set<size_t>& kept, int joint) {
  std::optional<size_t> out;
  bool here = false;
  for (const size_t k : kept) {
    const Finding& f = d.findings[first + k];
    const bool own = f.joint && f.joint->value == joint;
    const bool costs = own_gain(f, joint) < 0.0;
    if (!own && !costs) continue;
    const bool better = !out || (own && !here) ||
                        (own == here && own_gain(f, joint) < own_gain(d.findings[first + *out], joint));
    if (!better || (here && !own)) continue;
    out = k;
    here = own;
  }
  return out;
}

// The joint that a cable on a joint comes from.
std::optional<int> source_of(const Diagnosis& d, const Finding& f) {
  for (const EffectTerm& term : d.extended.model->effects()) {
    if (term.effect == effect_of(f.cause) && term.from && f.joint && term.axis.coefficients[f.joint->value] != 0.0)
      return main_coordinate(*term.from);
  }
  return std::nullopt;
}

// True if the interval of a load's size holds zero.
bool may_be_zero(const Finding& load, const std::string& size) {
  return std::any_of(load.parameters.begin(), load.parameters.end(), [&size](const FoundParameter& p) {
    return p.name == size && p.low <= 0.0;
  });
}

}  // namespace

bool has_curve(const Diagnosis& d, int joint, const std::string& signal) {
  return std::any_of(d.findings.begin(), d.findings.end(), [&](const Finding& f) {
    if (!f.shape || f.joint->value != joint) return false;
    const std::vector<std::string>& of = f.shape->signals;
    return signal.empty() || std::find(of.begin(), of.end(), signal) != of.end();
  });
}

bool is_no_factor(const Diagnosis& d, const Finding& f) {
  if (!std::holds_alternative<ChannelError>(f.cause) || !f.joint) return false;
  const auto* sensor = dynamic_cast<const SensorError*>(&find_effect(effect_of(f.cause)));
  return sensor != nullptr && sensor->scales_torque() &&
         has_curve(d, f.joint->value, "tau" + std::to_string(f.joint->value + 1));
}

std::string why_no_finding(const Finding& f, const Identification& fitted) {
  if (std::holds_alternative<AddedLoad>(f.cause) && may_be_zero(f, "mass") && may_be_zero(f, "moment"))
    return "neither its mass nor its moment can be told from zero";
  const std::string effect = effect_of(f.cause);
  int sizes = 0;
  int nothing = 0;
  for (const FoundParameter& p : f.parameters) {
    if (!is_size(effect, p.name)) continue;
    ++sizes;
    nothing += p.low <= 0.0 && p.high >= 0.0 ? 1 : 0;
    const bool effort = p.unit == "N m" || p.unit == "N";
    if (!effort || !f.joint) continue;
    const double most = largest_torque(fitted, f.joint->value);
    if (most > 0.0 && std::abs(p.value) > most) {
      return fmt::format("{} of {:.3g} {} is more than the joint's torque ever was ({:.3g} {})", p.name,
                         p.value, p.unit, most, p.unit);
    }
  }
  // Several sizes of one curve may each be nothing while the curve is not: their p value counts.
  if (sizes == 1 && nothing == 1) return "its interval holds zero after the last fit";
  return {};
}

std::optional<LostRight> without_size(const Diagnosis& d, size_t first, const std::set<size_t>& kept) {
  for (const size_t k : kept) {
    const Finding& f = d.findings[first + k];
    const std::string why = why_no_finding(f, d.extended);
    if (!why.empty()) return LostRight{k, f.joint ? f.joint->value : 0, why};
  }
  return std::nullopt;
}

std::vector<int> worse_joints(const FoldErrors& baseline, const FoldErrors& extended, const Thresholds& limits) {
  const VectorXd before = baseline.relative();
  const VectorXd after = extended.relative();
  std::vector<int> out;
  for (Eigen::Index j = 0; j < before.size(); ++j) {
    if (after[j] <= (1.0 + limits.held_out_worse) * before[j]) continue;
    if (worse_by_standard_errors(baseline.error2.col(j) / baseline.torque2[j],
                                 extended.error2.col(j) / extended.torque2[j]) >= 1.0)
      out.push_back(static_cast<int>(j));
  }
  return out;
}

std::optional<LostRight> worse_with(const Diagnosis& d, size_t first, const std::set<size_t>& kept,
                                    const std::set<size_t>& needed, const FoldErrors& baseline,
                                    const FoldErrors& extended, const Thresholds& limits) {
  std::set<size_t> some;
  std::set_difference(kept.begin(), kept.end(), needed.begin(), needed.end(),
                      std::inserter(some, some.begin()));
  for (const int joint : worse_joints(baseline, extended, limits)) {
    if (const std::optional<size_t> k = least_needed(d, first, some, joint))
      return LostRight{*k, joint, fmt::format("without it joint {} is predicted better, which was worse than by the baseline", joint + 1)};
  }
  return std::nullopt;
}

std::string why_doubted(const Diagnosis& d, const Finding& f, const std::set<int>& above) {
  if (f.shape || above.empty() || !(std::holds_alternative<KinematicError>(f.cause) || has_effect(effect_of(f.cause))))
    return {};
  const bool constant = std::holds_alternative<KinematicError>(f.cause);
  const EffectTraits traits = constant ? EffectTraits() : find_effect(effect_of(f.cause)).traits();
  const bool of_all = constant || (std::holds_alternative<ChannelError>(f.cause) && traits.depends_on_position);
  if (of_all && f.folds_before.size() == f.folds_after.size()) {
    double here = 0.0;
    double elsewhere = 0.0;
    for (int j = 0; j < f.folds_before.size(); ++j)
      (above.count(j) != 0 ? here : elsewhere) += 2.0 * std::log(f.folds_before[j] / f.folds_after[j]);
    if (elsewhere <= here) return "it shows most on joints that have more than their floor without a name";
  }
  if (std::holds_alternative<NewEffect>(f.cause) && traits.uses_source) {
    const std::optional<int> from = source_of(d, f);
    if (from && has_curve(d, *from, "q" + std::to_string(f.joint->value + 1)))
      return "the joint that it comes from has an error without a name that depends on this joint: one cause acts on both";
  }
  return {};
}

}  // namespace veridyn
