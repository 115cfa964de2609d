#include "diagnosis/stages/channel_correction.hpp"

#include <algorithm>
#include <cmath>

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

// A factor is positive: a torque with the wrong sign is no error of its gain.
bool is_possible(const Hypothesis& h, const std::vector<double>& values) {
  for (size_t p = 0; p < values.size(); ++p) {
    if (is_relative(h, p) && values[p] <= -1.0) return false;
  }
  return true;
}

}  // namespace

std::vector<double> together(const Hypothesis& h, const std::vector<double>& first,
                             const std::vector<double>& second) {
  std::vector<double> out;
  for (size_t p = 0; p < first.size(); ++p) {
    out.push_back(is_relative(h, p) ? (1.0 + first[p]) * (1.0 + second[p]) - 1.0 : first[p] + second[p]);
  }
  return out;
}

std::optional<CorrectedChannel> correct_channel(const DiagnosisState& x, const CandidateTests& asked,
                                                const Hypothesis& h) {
  std::optional<Estimate> step = estimate(asked, h, x.options);
  if (!step) return std::nullopt;
  CorrectedChannel out{x.start, std::vector<double>(step->values.size(), 0.0), {}};
  bool moved = false;
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
    CandidateList list = x.list();
    list.wanted = {effect_of(h.cause)};
    const CandidateTests again = prepare_tests(x, list, out.corrected);
    const Hypothesis* same_one = same(again, h);
    step = same_one == nullptr ? std::nullopt : estimate(again, *same_one, x.options);
  }
  if (!moved) return std::nullopt;
  return out;
}

}  // namespace veridyn
