#include "diagnosis/stages/channel_correction.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/evidence/effect_facts.hpp"
#include "diagnosis/evidence/numerics.hpp"
#include "diagnosis/shapes/refinement.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "math/student_t.hpp"

namespace veridyn {
namespace {

// Values of one hypothesis fitted beside the base columns, with half widths of their intervals.
struct Estimate {
  EffectTerm term;
  std::vector<double> values;
  VectorXd half_widths;
};

std::optional<Estimate> estimate(const CandidateTests& asked, const Hypothesis& h,
                                 const DiagnosisOptions& options) {
  const ColumnSet own = columns_of(asked.data, h);
  if (own.empty()) return std::nullopt;
  const Selection fit = refit(asked.data, asked.q.base, {h}, options);
  const double t = student_t_quantile(numerics::kOutside, fit.degrees_of_freedom);
  Estimate out{term_of(asked.q.augmented.model, h), {}, {}};
  out.half_widths = VectorXd::Zero(h.columns.size());
  const auto first = static_cast<Eigen::Index>(fit.columns.size() - own.size());
  Eigen::Index p = 0;
  for (const std::string& name : h.columns) {  // a column that is nothing everywhere is not among `own`
    double value = 0.0;
    for (size_t k = 0; k < own.size(); ++k) {
      if (asked.data.names()[own[k]] != name) continue;
      const Eigen::Index at = first + static_cast<Eigen::Index>(k);
      value = fit.values[at];
      out.half_widths[p] = t * fit.standard_deviations[at];
    }
    out.values.push_back(value);
    ++p;
  }
  return out;
}

// Keeps sizes that cannot be negative at zero or above: a base is no stiffer than rigid.
void keep_possible(const Hypothesis& h, const std::vector<double>& so_far, std::vector<double>& step) {
  const std::vector<EffectParameter> parameters = find_effect(effect_of(h.cause)).parameters();
  for (size_t p = 0; p < step.size(); ++p) {
    if (parameters[p].sign == ParameterSign::kNonnegative) step[p] = std::max(step[p], -so_far[p]);
  }
}

// True if a size is beyond what is plausible: the tangent at zero says little there.
bool leads_far(const Hypothesis& h, const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [&h](double value) { return std::abs(value) > h.largest_value; });
}

const ArmEffect* arm_effect_of(const Hypothesis& h) {
  return dynamic_cast<const ArmEffect*>(&find_effect(effect_of(h.cause)));
}

// The same hypothesis for another arm.
const Hypothesis* same(const CandidateTests& asked, const Hypothesis& h) {
  for (const Hypothesis& other : asked.q.augmented.hypotheses) {
    if (same_candidate(other, h)) return &other;
  }
  return nullptr;
}

// True if a parameter is the relative error of a factor, and no share of another joint.
bool is_relative(const Hypothesis& h, size_t p) {
  return !h.from && find_effect(effect_of(h.cause)).parameters()[p].unit_revolute == "1";
}

std::vector<double> values_in(const Finding& f) {
  std::vector<double> out;
  for (const FoundParameter& p : f.parameters) out.push_back(p.value);
  return out;
}

// A factor is positive: a torque with the wrong sign is no error of its gain.
bool is_possible(const Hypothesis& h, const std::vector<double>& values) {
  for (size_t p = 0; p < values.size(); ++p) {
    if (is_relative(h, p) && values[p] <= -1.0) return false;
  }
  return true;
}

}  // namespace

std::vector<double> values_so_far(const Model& first, const Hypothesis& h, const CorrectedChannel& channel,
                                  std::vector<double> sum) {
  const ArmEffect* effect = arm_effect_of(h);
  if (effect == nullptr) return sum;
  return effect->values_between(first.description(), channel.corrected.model->description(), std::move(sum));
}

std::vector<double> together(const Hypothesis& h, const std::vector<double>& first,
                             const std::vector<double>& second) {
  std::vector<double> out;
  for (size_t p = 0; p < first.size(); ++p) {
    out.push_back(is_relative(h, p) ? (1.0 + first[p]) * (1.0 + second[p]) - 1.0 : first[p] + second[p]);
  }
  return out;
}

void merge_corrections(const Model& arm, size_t first, std::vector<Finding>& all) {
  for (size_t k = all.size(); k-- > first;) {
    const Finding& more = all[k];
    const auto behind = all.begin() + static_cast<long>(first);
    const auto earlier = std::find_if(all.begin(), behind, [&more](const Finding& f) {
      return std::holds_alternative<ChannelError>(f.cause) && effect_of(f.cause) == effect_of(more.cause) &&
             f.joint == more.joint && f.from == more.from;
    });
    if (!std::holds_alternative<ChannelError>(more.cause) || earlier == behind) continue;
    if (more.status == FindingStatus::kConfirmed) {
      Hypothesis h;
      h.cause = more.cause;
      h.from = more.from;
      const std::vector<double> values = together(h, values_in(*earlier), values_in(more));
      for (size_t p = 0; p < values.size(); ++p) {
        FoundParameter& sum = earlier->parameters[p];
        const double change = values[p] - sum.value;
        sum = {sum.name, sum.unit, values[p], sum.low + change, sum.high + change};
      }
      EffectTerm term;
      term.effect = effect_of(more.cause);
      term.axis.coefficients = VectorXd::Zero(arm.joints());
      if (more.joint) term.axis.coefficients[more.joint->value] = 1.0;
      if (more.from) term.from = Axis{VectorXd::Unit(arm.joints(), more.from->value), 0.0};
      earlier->phrase = channel_phrase(arm, term, values);
    }
    all.erase(all.begin() + static_cast<long>(k));
  }
}

std::optional<CorrectedChannel> correct_channel(const DiagnosisState& x, const CandidateTests& asked,
                                                const Hypothesis& h) {
  std::optional<Estimate> step = estimate(asked, h, x.options);
  if (!step) return std::nullopt;
  const auto estimate_again = [&](const Identification& corrected) {
    CandidateList list = x.list();
    list.wanted = {effect_of(h.cause)};
    const CandidateTests again = prepare_tests(x, list, corrected);
    const Hypothesis* same_one = same(again, h);
    return same_one == nullptr ? std::nullopt : estimate(again, *same_one, x.options);
  };
  CorrectedChannel out{x.start, std::vector<double>(step->values.size(), 0.0), {}};
  bool moved = false;
  if (const ArmEffect* effect = arm_effect_of(h); effect != nullptr && leads_far(h, step->values)) {
    for (const std::vector<double>& values : effect->far_values()) {
      Identification candidate = x.fit(with_channel_error(*x.start.model, step->term, values));
      if (!candidate.model || log_training_error(candidate) >= log_training_error(out.corrected)) continue;
      out.corrected = std::move(candidate);
      out.values = values;
      moved = true;
    }
    if (moved) step = estimate_again(out.corrected);
  }
  for (int k = 0; k < numerics::kChannelSteps && step; ++k) {
    out.half_widths = step->half_widths;
    // Once a step is small beside its own uncertainty there is nothing left to gain.
    bool matters = k == 0;
    for (size_t p = 0; p < step->values.size(); ++p)
      matters = matters || std::abs(step->values[p]) >
                               0.5 * 0.5 * step->half_widths[static_cast<Eigen::Index>(p)];
    if (!matters) break;
    keep_possible(h, out.values, step->values);
    bool better = false;
    for (int halving = 0; halving < numerics::kHalvings && !better; ++halving) {
      if (is_possible(h, step->values)) {
        const Identification candidate =
            x.fit(with_channel_error(*out.corrected.model, step->term, step->values));
        better = candidate.model && log_training_error(candidate) < log_training_error(out.corrected);
        if (better) out.corrected = candidate;
      }
      for (double& value : step->values) value *= better ? 1.0 : 0.5;
    }
    if (!better) break;
    moved = true;
    out.values = together(h, out.values, step->values);
    step = estimate_again(out.corrected);
  }
  if (!moved) return std::nullopt;
  out.values = values_so_far(*x.start.model, h, out, std::move(out.values));
  return out;
}

}  // namespace veridyn
