#include "diagnosis/findings/finding_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/evidence/effect_facts.hpp"
#include "diagnosis/evidence/payload_fit.hpp"
#include "diagnosis/evidence/folds.hpp"
#include "diagnosis/evidence/numerics.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "math/student_t.hpp"
#include "veridyn/effects/effect_facts.hpp"

namespace veridyn {
namespace {

// "Joint 3 (insertion)", or "The arm".
std::string place_of(const CauseWords& w) {
  if (w.joint < 1) return "The arm";
  return "Joint " + std::to_string(w.joint) + " (" + w.coordinate + ")";
}

const FoundParameter* find_parameter(const std::vector<FoundParameter>& all, const std::string& name) {
  const auto found = std::find_if(all.begin(), all.end(), [&name](const FoundParameter& p) { return p.name == name; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace

Finding finding_at(const Hypothesis& h) {
  Finding f;
  f.cause = h.cause;
  f.joint = h.joint;
  f.from = h.from;
  return f;
}

std::string sentence(const Model& arm, const Finding& f) {
  const CauseWords w = words_of(arm, f.cause);
  std::string out = place_of(w) + ": " + f.phrase + ".";
  if (std::holds_alternative<AddedLoad>(f.cause)) {
    const bool taken_off = f.phrase.find("was taken off") != std::string::npos;
    out = f.phrase + (taken_off ? " " : " sits on ") + w.frame + ".";
    out.front() = 'A';
  }
  if (std::holds_alternative<ChannelError>(f.cause)) out = place_of(w) + " has " + f.phrase + ".";
  if (std::holds_alternative<KinematicError>(f.cause))
    out = "The robot file has a wrong constant: " + f.phrase + ".";
  if (std::holds_alternative<ExternalContact>(f.cause)) out = f.source + ": " + f.phrase + ".";
  return f.remark.empty() ? out : out + " " + f.remark;
}

std::string remark_on_size(const Hypothesis& h, const std::vector<double>& values) {
  const bool large = std::any_of(values.begin(), values.end(), [&h](double value) {
    return std::abs(value) > h.largest_value;
  });
  return large ? "That is unusually large for an error of this kind." : "";
}

Finding channel_finding(const CandidateData& asked, const Hypothesis& h,
                        const std::vector<double>& values, const VectorXd& half_widths) {
  const Model& arm = asked.augmented.model;
  const EffectTerm& term = term_of(arm, h);
  Finding f = finding_at(h);
  const std::vector<EffectParameter> parameters = find_effect(term.effect).parameters();
  const bool slides = h.joint && is_prismatic(arm, term.axis);
  for (size_t p = 0; p < values.size(); ++p) {
    const double half = half_widths[static_cast<Eigen::Index>(p)];
    f.parameters.push_back(
        {parameters[p].name, slides ? parameters[p].unit_prismatic : parameters[p].unit_revolute,
         values[p], values[p] - half, values[p] + half});
  }
  f.unit = f.parameters.front().unit;
  f.phrase = channel_phrase(arm, term, values);
  f.remark = remark_on_size(h, values);
  return f;
}

std::vector<Rival> rivals_of(const CandidateData& asked, const NormalBlocks& data, const Hypothesis& h,
                             const Accepted& accepted, bool changes) {
  std::vector<Rival> out;
  for (const Evidence& e : accepted.rivals) {
    const Hypothesis& other = asked.augmented.hypotheses[e.hypothesis];
    const bool same = is_load(h) && is_load(other) && same_torques(data, h, other);
    out.push_back({other.cause,
                   same ? "moves so alike that torques cannot tell which link carries it"
                        : fmt::format("gains {:.0f} % as much on held-out data",
                                      numerics::kPercent * e.gain /
                                          std::max(numerics::kNoise, accepted.evidence.gain))});
  }
  const bool constant =
      !is_load(h) && find_effect(effect_of(h.cause)).traits().same_as_wrong_constant;
  if (constant && h.joint && !changes) {
    out.push_back({KinematicError{JointZero{*h.joint}},
                   "a wrong zero of this joint in the robot file does exactly the same"});
  }
  return out;
}

std::vector<FoundParameter> load_parameters(const PayloadEstimate& load) {
  std::vector<FoundParameter> out = {{"mass", "kg", load.mass, load.mass_low, load.mass_high}};
  double half = 0.0;
  for (int c = 0; c < 3; ++c) {
    if (!load.seen[static_cast<size_t>(c)]) continue;
    half = std::hypot(half, load.moment_half_width[c]);
    if (load.mass_low <= 0.0) continue;
    out.push_back({std::string(1, "xyz"[c]), "m", load.com[c], load.com[c] - load.com_half_width[c],
                   load.com[c] + load.com_half_width[c]});
  }
  const double lever = load.moment.norm();
  out.push_back({"moment", "kg m", lever, std::max(0.0, lever - half), lever + half});
  return out;
}

std::string load_phrase(const std::vector<FoundParameter>& of) {
  const FoundParameter& mass = *find_parameter(of, "mass");
  if (mass.low > 0.0)
    return fmt::format("a load of {:.3g} kg (95 %: {:.3g} to {:.3g})", mass.value, mass.low, mass.high);
  const FoundParameter& moment = *find_parameter(of, "moment");
  return fmt::format("a load with a moment of {:.3g} kg m (95 %: {:.3g} to {:.3g}) and a mass that may be zero (at most {:.3g} kg)",
                     moment.value, moment.low, moment.high, mass.high);
}

std::vector<FoundParameter> known_to_both(const std::vector<FoundParameter>& first,
                                          const std::vector<FoundParameter>& second) {
  std::vector<FoundParameter> out;
  for (const FoundParameter& p : first) {
    const FoundParameter* other = find_parameter(second, p.name);
    if (other != nullptr) out.push_back({p.name, p.unit, p.value, std::min(p.low, other->low), std::max(p.high, other->high)});
  }
  return out;
}

namespace {

// The words of a single effect, from its values in the model.
void renew_phrase(const Model& arm, const std::vector<std::string>& names, Finding& f) {
  for (const EffectTerm& term : arm.effects()) {
    if (!has_axis_effect(term.effect)) continue;
    const EffectFacts effect(arm, term);
    const auto count = static_cast<size_t>(effect.parameter_count());
    if (count != names.size() || effect.parameter_name(0) != names.front()) continue;
    std::vector<double> values;
    for (size_t p = 0; p < count; ++p) values.push_back(f.parameters[p].value);
    f.phrase = effect.phrase(values);
  }
}

}  // namespace

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
  renew_phrase(*id.model, names, f);
}

bool falls(const VectorXd& before, const VectorXd& after, std::optional<JointIndex> joint) {
  return log_fall(before, after) > 0.0 && (!joint || after[joint->value] <= before[joint->value]);
}

// The joint whose torque alone depends on the cause: a wrong zero of one encoder shows on all joints.
static std::optional<JointIndex> only_joint(const Finding& f) {
  if (std::holds_alternative<KinematicError>(f.cause)) return std::nullopt;
  if (!f.joint || !std::holds_alternative<ChannelError>(f.cause)) return f.joint;
  const auto* channel = dynamic_cast<const ChannelEffect*>(&find_effect(effect_of(f.cause)));
  const int another = f.joint->value == 0 ? 1 : 0;
  return channel != nullptr && channel->acts_on(another, f.joint) ? std::nullopt : f.joint;
}

JointVerdict not_judged(JointIndex joint, double held_out, const Identification& baseline) {
  JointVerdict v;
  v.joint = joint;
  v.held_out = v.extended = held_out;
  v.state = JointState::kCannotTell;
  v.why = baseline.test.empty() ? "no recording is held out, on which its error would be measured"
                                : "its torque is zero throughout the held-out recordings, and no error is a share of it";
  return v;
}

JointVerdict no_torque_verdict(JointIndex joint) {
  JointVerdict v;
  v.joint = joint;
  v.held_out = v.extended = std::numeric_limits<double>::infinity();
  v.state = JointState::kCannotTell;
  v.why = "its torque is zero throughout the training recordings (not recorded, or nothing drove it): nothing is asked about it";
  return v;
}

FindingStatus status_of(const Finding& f) {
  const bool measured = f.folds_before.size() > 0 && f.folds_after.size() == f.folds_before.size();
  return !measured || falls(f.folds_before, f.folds_after, only_joint(f)) ? FindingStatus::kConfirmed
                                                                    : FindingStatus::kNotConfirmed;
}

Agreement Finding::held_out() const {
  if (test_before.size() == 0 || test_after.size() != test_before.size())
    return Agreement::kNotMeasured;
  return falls(test_before, test_after, only_joint(*this)) ? Agreement::kAgrees : Agreement::kContradicts;
}

const char* name_of(Agreement agreement) {
  switch (agreement) {
    case Agreement::kAgrees: return "agrees";
    case Agreement::kContradicts: return "contradicts";
    case Agreement::kNotMeasured: return "not_measured";
  }
  return "";
}

const char* name_of(FindingStatus status) {
  return status == FindingStatus::kConfirmed ? "confirmed" : "not_confirmed";
}

}  // namespace veridyn
