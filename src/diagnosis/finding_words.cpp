#include "diagnosis/finding_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/causes/effect_facts.hpp"
#include "diagnosis/causes/payload_fit.hpp"
#include "diagnosis/evidence/folds.hpp"
#include "diagnosis/numerics.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "math/student_t.hpp"

namespace veridyn {
namespace {

Rival rival(const Model& arm, const Hypothesis& h, const std::string& why) {
  const Finding at = finding_at(arm, h);
  return {at.effect, at.joint, at.coordinate, why, at.frame};
}

}  // namespace

Finding finding_at(const Model& arm, const Hypothesis& h) {
  Finding f;
  f.effect = h.effect;
  f.joint = h.joint + 1;
  f.coordinate = h.joint < 0 ? "arm" : arm.coordinates()[static_cast<size_t>(h.joint)].name;
  if (h.body >= 0) f.frame = arm.frames()[static_cast<size_t>(h.frame)].name;
  return f;
}

std::string place_words(const Finding& f) {
  if (f.joint < 1) return "The arm";
  return "Joint " + std::to_string(f.joint) + " (" + f.coordinate + ")";
}

std::string remark_on_size(const Hypothesis& h, const std::vector<double>& values) {
  const bool large = std::any_of(values.begin(), values.end(), [&h](double value) {
    return std::abs(value) > h.largest_value;
  });
  return large ? " That is unusually large for an error of this kind." : "";
}

Finding channel_finding(const Inquiry& asked, const Hypothesis& h,
                        const std::vector<double>& values, const VectorXd& half_widths) {
  const Model& arm = asked.augmented.model;
  const EffectTerm& term = arm.effects()[static_cast<size_t>(h.term)];
  Finding f = finding_at(arm, h);
  const std::vector<EffectParameter> parameters = find_effect(h.effect).parameters();
  const bool slides = h.joint >= 0 && is_prismatic(arm, term.axis);
  for (size_t p = 0; p < values.size(); ++p) {
    const double half = half_widths[static_cast<Eigen::Index>(p)];
    f.parameters.push_back(
        {parameters[p].name, slides ? parameters[p].unit_prismatic : parameters[p].unit_revolute,
         values[p], values[p] - half, values[p] + half});
  }
  f.unit = f.parameters.front().unit;
  f.sentence = place_words(f) + " has " + channel_phrase(arm, term, values) + "." +
               remark_on_size(h, values);
  return f;
}

std::vector<Rival> rivals_of(const Inquiry& asked, const NormalBlocks& data, const Hypothesis& h,
                             const Accepted& accepted, bool changes) {
  const Model& arm = asked.augmented.model;
  std::vector<Rival> out;
  for (const Evidence& e : accepted.rivals) {
    const Hypothesis& other = asked.augmented.hypotheses[static_cast<size_t>(e.hypothesis)];
    const bool same = h.body >= 0 && other.body >= 0 && same_torques(data, h, other);
    out.push_back(
        rival(arm, other,
              same ? "moves so alike that torques cannot tell which link carries it"
                   : fmt::format("gains {:.0f} % as much on held-out data",
                                 numerics::kPercent * e.gain /
                                     std::max(numerics::kNoise, accepted.evidence.gain))));
  }
  if (h.body < 0 && !changes && find_effect(h.effect).traits().same_as_wrong_constant) {
    Rival same = rival(arm, h, "a wrong zero of this joint in the robot file does exactly the same");
    same.effect = KinematicError::kName;
    out.push_back(same);
  }
  return out;
}

void refresh(const Identification& id, const std::vector<std::string>& names, Finding& f) {
  if (!id.model || id.parameters.size() == 0) return;
  const std::vector<std::string> all = parameter_names(standard_parameters(*id.model));
  const double t = student_t_quantile(numerics::kOutside, std::max(1.0, id.effective_samples));
  for (size_t p = 0; p < names.size() && p < f.parameters.size(); ++p) {
    const auto found = std::find(all.begin(), all.end(), names[p]);
    if (found == all.end()) continue;
    const Eigen::Index at = found - all.begin();
    const double deviation = id.parameter_deviations[at];
    if (!std::isfinite(deviation)) continue;
    FoundParameter& parameter = f.parameters[p];
    // The interval of the fit that found it, moved; it counts what differs between recordings.
    const double half = std::max(t * deviation, 0.5 * (parameter.high - parameter.low));
    parameter.value = id.parameters[at];
    parameter.low = parameter.value - half;
    parameter.high = parameter.value + half;
  }
}

FindingStatus status_of(const Finding& f) {
  if (f.test_before.size() == 0 || f.test_after.size() != f.test_before.size())
    return FindingStatus::kConfirmed;
  const bool falls = log_fall(f.test_before, f.test_after) > 0.0;
  const Eigen::Index own = f.joint - 1;
  const bool own_falls = own < 0 || f.test_after[own] <= f.test_before[own];
  return falls && own_falls ? FindingStatus::kConfirmed : FindingStatus::kNotConfirmed;
}

const char* name_of(FindingStatus status) {
  return status == FindingStatus::kConfirmed ? "confirmed" : "not_confirmed";
}

}  // namespace veridyn
