#include "diagnosis/findings/finding_words.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/numerics.hpp"
#include "math/student_t.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/effects/effect_facts.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn {
namespace {

// "Joint 3 (insertion)", or "The arm".
std::string place_of(const CauseWords& w) {
  if (!w.joint) return "The arm";
  return "Joint " + std::to_string(w.joint->value + 1) + " (" + w.coordinate + ")";
}

}  // namespace

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

namespace {

// Writes the phrase of a finding with a single effect anew, from the effect's values in the model.
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
    // Keeps the width of the first fit's interval, which includes differences between recordings.
    const double half = std::max(t * deviation, 0.5 * (parameter.high - parameter.low));
    parameter.value = id.parameters[at];
    parameter.low = parameter.value - half;
    parameter.high = parameter.value + half;
  }
  renew_phrase(*id.model, names, f);
}

bool error_falls(const VectorXd& before, const VectorXd& after, std::optional<JointIndex> joint) {
  // A joint without torque has an infinite relative error before and after, and is left out of the sum.
  const auto sum = [](const VectorXd& errors) { return errors.array().max(numerics::kTiny).min(numerics::kHuge).log().sum(); };
  return sum(before) > sum(after) && (!joint || after[joint->value] <= before[joint->value]);
}

// The joint on whose torque alone the error is judged; none for a load, or a wrong zero of an encoder, which affect
// others as well.
static std::optional<JointIndex> only_joint(const Finding& f) {
  if (std::holds_alternative<KinematicError>(f.cause) || std::holds_alternative<AddedLoad>(f.cause)) return std::nullopt;
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
  return !measured || error_falls(f.folds_before, f.folds_after, only_joint(f)) ? FindingStatus::kConfirmed
                                                                    : FindingStatus::kNotConfirmed;
}

Agreement Finding::held_out() const {
  // A push is no property of the arm: other recordings cannot confirm it.
  if (test_before.size() == 0 || test_after.size() != test_before.size() || std::holds_alternative<ExternalContact>(cause))
    return Agreement::kNotMeasured;
  return error_falls(test_before, test_after, only_joint(*this)) ? Agreement::kAgrees : Agreement::kContradicts;
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
