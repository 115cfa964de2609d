#include "findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "diagnosis/causes/extended_arm.hpp"
#include "diagnosis/evidence/held_out.hpp"
#include "diagnosis/causes/payload_fit.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/identification/arm_effects.hpp"
#include "veridyn/math/student_t.hpp"

namespace veridyn {
namespace {

constexpr size_t kListed = 60;  // of what the data rule out

const EffectTerm& term_of(const Inquiry& q, const Hypothesis& h) {
  return q.augmented.model.effects()[static_cast<size_t>(h.term)];
}

std::string place_text(const Model& arm, const Hypothesis& h) {
  if (h.body >= 0) return "on " + arm.frames()[static_cast<size_t>(h.frame)].name;
  if (h.joint < 0) return "of the arm";
  return "on joint " + std::to_string(h.joint + 1);
}

// Why a hypothesis that these data can answer was not accepted.
std::string why_not(const Evidence& e, const DiagnosisOptions& limits) {
  if (e.sign_broken) return "its value would have an impossible sign or size";
  if (e.gain <= 0.0) return "held-out data are predicted no better";
  if (e.gain <= limits.smallest_gain) return "held-out data gain too little from it";
  if (!e.consistent) return "it helps in some of the held-out parts only";
  return "its value is not certain enough among so many questions";
}

}  // namespace

FindingWriter::FindingWriter(const Inquiry& asked, const NormalBlocks& asked_data,
                             const Selection& selection, const Fit& fit,
                             const Identification& start, bool changes,
                             const DiagnosisOptions& limits)
    : asked_(asked),
      asked_data_(asked_data),
      selection_(selection),
      fit_(fit),
      q_(fit.inquiry),
      data_(*fit.data),
      start_(start),
      changes_(changes),
      limits_(limits) {
  for (const Hypothesis& h : q_.augmented.hypotheses)
    payloads_.push_back(h.body >= 0 ? fit_payload(asked_, asked_data_, asked_hypothesis(h))
                                    : PayloadEstimate());
}

const Hypothesis& FindingWriter::accepted(size_t k) const {
  return q_.augmented.hypotheses[k];
}

// The same payload among all that was asked: with the columns of what may have changed beside it.
const Hypothesis& FindingWriter::asked_hypothesis(const Hypothesis& h) const {
  return *std::find_if(asked_.augmented.hypotheses.begin(), asked_.augmented.hypotheses.end(),
                       [&h](const Hypothesis& other) { return other.family == h.family; });
}

Rival FindingWriter::rival(const Hypothesis& h, const std::string& why) const {
  const Model& arm = q_.augmented.model;
  Rival out{h.effect, h.joint + 1,
            h.joint < 0 ? "arm" : arm.coordinates()[static_cast<size_t>(h.joint)].name, why, ""};
  if (h.body >= 0) out.frame = arm.frames()[static_cast<size_t>(h.frame)].name;
  return out;
}

std::vector<double> FindingWriter::values_of(const Hypothesis& h) const {
  std::vector<double> out;
  for (const std::string& name : h.columns) {
    double value = 0.0;
    for (size_t k = 0; k < fit_.selection.columns.size(); ++k) {
      if (data_.names()[static_cast<size_t>(fit_.selection.columns[k])] == name)
        value = fit_.selection.values[static_cast<Eigen::Index>(k)];
    }
    out.push_back(value);
  }
  return out;
}

std::vector<FoundParameter> FindingWriter::payload_parameters(const Hypothesis& h) const {
  for (size_t k = 0; k < payloads_.size(); ++k) {
    if (&accepted(k) != &h) continue;
    const PayloadEstimate& p = payloads_[k];
    std::vector<FoundParameter> out = {{"mass", "kg", p.mass, p.mass_low, p.mass_high}};
    for (int c = 0; c < 3; ++c)
      out.push_back({std::string(1, "xyz"[c]), "m", p.com[c], p.com[c] - p.com_half_width[c],
                     p.com[c] + p.com_half_width[c]});
    const double lever = p.moment.norm();
    const double half = p.moment_half_width.norm();
    out.push_back({"moment", "kg m", lever, std::max(0.0, lever - half), lever + half});
    return out;
  }
  return {};
}

// A change is no better known than what it is a change of.
double FindingWriter::own_deviation(const Hypothesis& h, const std::string& parameter) const {
  if (h.changes < 0) return 0.0;
  const EffectTerm& own = q_.augmented.model.effects()[static_cast<size_t>(h.changes)];
  const auto found = own.deviations.find(parameter);
  return found == own.deviations.end() || !std::isfinite(found->second) ? 0.0 : found->second;
}

std::vector<FoundParameter> FindingWriter::parameters_of(const Hypothesis& h) const {
  if (h.body >= 0) return payload_parameters(h);
  const EffectTerm& term = term_of(q_, h);
  const std::vector<StandardParameter> all = standard_parameters(q_.augmented.model);
  const double t = student_t_quantile(0.05, fit_.selection.degrees_of_freedom);
  std::vector<FoundParameter> out;
  for (const StandardParameter& parameter : all) {
    if (parameter.effect != h.term) continue;
    const auto at = static_cast<size_t>(parameter.component);
    const std::string name = is_arm_effect(term.effect)
                                 ? arm_effect_parameters(term.effect)[at].name
                                 : find_effect(term.effect).parameters()[at].name;
    FoundParameter found{name, parameter.unit, 0.0, 0.0, 0.0};
    for (size_t k = 0; k < fit_.selection.columns.size(); ++k) {
      if (data_.names()[static_cast<size_t>(fit_.selection.columns[k])] != parameter.name) continue;
      const auto column = static_cast<Eigen::Index>(k);
      found.value = fit_.selection.values[column];
      const double half =
          t * std::hypot(fit_.selection.standard_deviations[column], own_deviation(h, name));
      found.low = found.value - half;
      found.high = found.value + half;
    }
    out.push_back(found);
  }
  if (is_arm_effect(term.effect)) return out;
  const bool slides = is_prismatic(q_.augmented.model, term.axis);
  for (const EffectShape& shape : find_effect(term.effect).shapes()) {
    const auto value = term.values.find(shape.name);
    if (value == term.values.end()) continue;
    // Constants that nobody searched (where a slope is counted from) are no findings.
    for (const ShapeInterval& interval : fit_.selection.shapes) {
      if (&accepted(static_cast<size_t>(interval.hypothesis)) != &h || interval.shape != shape.name)
        continue;
      out.push_back({shape.name, slides ? shape.unit_prismatic : shape.unit_revolute, value->second,
                     interval.low, interval.high});
    }
  }
  return out;
}

std::string FindingWriter::change_text(const Hypothesis& h, const Finding& f) const {
  const EffectTerm& own = q_.augmented.model.effects()[static_cast<size_t>(h.changes)];
  std::string words = h.effect;
  std::replace(words.begin(), words.end(), '_', ' ');
  std::string out = words + " changed";
  for (size_t p = 0; p < h.columns.size(); ++p) {
    const FoundParameter& change = f.parameters[p];
    const auto before = own.values.find(change.name);
    const double from = before == own.values.end() ? 0.0 : before->second;
    out += fmt::format("{} from {:.3g} to {:.3g} {}", p == 0 ? "" : ",", from, from + change.value,
                       change.unit);
  }
  return out;
}

std::string FindingWriter::sentence(const Hypothesis& h, const Finding& f) const {
  const Model& arm = q_.augmented.model;
  const std::string joint =
      h.joint < 0 ? "" : "Joint " + std::to_string(f.joint) + " (" + f.coordinate + ")";
  if (h.body >= 0) {
    return fmt::format("A load of {:.3g} kg (95 %: {:.3g} to {:.3g}) sits on {}.",
                       f.parameters[0].value, f.parameters[0].low, f.parameters[0].high, f.frame);
  }
  if (h.changes >= 0) return joint + ": " + change_text(h, f) + ".";
  std::vector<double> values;
  for (size_t p = 0; p < h.columns.size(); ++p) values.push_back(f.parameters[p].value);
  if (is_arm_effect(h.effect)) {
    const std::string phrase = arm_effect_phrase(arm, term_of(q_, h), values);
    return (joint.empty() ? "The arm has " : joint + " has ") + phrase + ".";
  }
  return joint + ": " + BoundEffect(arm, term_of(q_, h)).phrase(values) + ".";
}

// Held-out error of the models that grow by one finding at a time, relative to what `start` shows.
std::vector<VectorXd> FindingWriter::errors_along_the_way() const {
  std::vector<VectorXd> out;
  if (q_.test.empty()) return out;
  const NormalBlocks test(q_.test, q_.columns, data_.scale());
  ColumnSet set = q_.base;
  VectorXd first;
  for (size_t k = 0; k <= selection_.accepted.size(); ++k) {
    const VectorXd w = joint_weights(data_, set);
    const VectorXd x = data_.solve(set, w, data_.total(), nullptr);
    const VectorXd r2 = test.residual2(set, x, test.total());
    if (k == 0) first = r2;
    out.push_back(start_.test_error.relative.array() *
                  (r2.array() / first.array().max(1e-300)).sqrt());
    if (k == selection_.accepted.size()) break;
    const ColumnSet own = columns_of(data_, accepted(k));
    set.insert(set.end(), own.begin(), own.end());
  }
  return out;
}

Finding FindingWriter::finding(size_t k, const VectorXd& before, const VectorXd& after) const {
  const Model& arm = q_.augmented.model;
  const Accepted& a = selection_.accepted[k];
  const Hypothesis& h = accepted(k);
  Finding f;
  f.effect = h.effect;
  f.joint = h.joint + 1;
  f.coordinate = h.joint < 0 ? "arm" : arm.coordinates()[static_cast<size_t>(h.joint)].name;
  if (h.body >= 0) f.frame = arm.frames()[static_cast<size_t>(h.frame)].name;
  f.parameters = parameters_of(h);
  if (!f.parameters.empty()) f.unit = f.parameters.front().unit;
  f.p_value = a.evidence.p_value;
  f.gain = a.evidence.gain;
  f.test_before = before;
  f.test_after = after;
  for (const Evidence& e : a.rivals) {
    const Hypothesis& other = asked_.augmented.hypotheses[static_cast<size_t>(e.hypothesis)];
    const bool same =
        h.body >= 0 && other.body >= 0 && same_torques(asked_data_, asked_hypothesis(h), other);
    f.rivals.push_back(
        rival(other, same ? "moves so alike that torques cannot tell which link carries it"
                          : fmt::format("gains {:.0f} % as much on held-out data",
                                        100.0 * e.gain / std::max(1e-12, a.evidence.gain))));
  }
  if (h.effect == "encoder_offset" && !changes_) {
    Rival same = rival(h, "a wrong zero of this joint in the robot file does exactly the same");
    same.effect = "coupling_error";
    f.rivals.push_back(same);
  }
  f.sentence = sentence(h, f);
  return f;
}

void FindingWriter::add_findings(Diagnosis& d) const {
  const std::vector<VectorXd> errors = errors_along_the_way();
  for (size_t k = 0; k < selection_.accepted.size(); ++k) {
    Finding f = errors.empty() ? finding(k, {}, {}) : finding(k, errors[k], errors[k + 1]);
    f.rank = static_cast<int>(d.findings.size()) + 1;
    f.explains = explained_share(f.test_before, f.test_after, d.baseline);
    d.findings.push_back(std::move(f));
  }
}

void FindingWriter::add_step(Finding& f) const {
  const Hypothesis& h = accepted(0);
  const std::vector<FoundParameter> step = parameters_of(h);
  for (size_t p = 0; p < f.parameters.size() && p < step.size(); ++p) {
    FoundParameter& total = f.parameters[p];
    total.low = total.value + step[p].low;
    total.high = total.value + step[p].high;
    total.value += step[p].value;
  }
  f.sentence = sentence(h, f);
}

void FindingWriter::add_the_rest(Diagnosis& d) const {
  std::set<std::string> known;
  for (size_t k = 0; k < selection_.accepted.size(); ++k) known.insert(accepted(k).family);
  std::vector<Evidence> rest = selection_.last_asked;
  const auto rank = [](const Evidence& e) { return e.taken ? 0 : e.absorbed ? 2 : 1; };
  std::stable_sort(rest.begin(), rest.end(), [&rank](const Evidence& a, const Evidence& b) {
    return rank(a) != rank(b) ? rank(a) < rank(b) : a.gain > b.gain;
  });
  for (const Evidence& e : rest) {
    const Hypothesis& h = asked_.augmented.hypotheses[static_cast<size_t>(e.hypothesis)];
    if (!known.insert(h.family).second) continue;
    if (e.taken) {
      d.not_supported.push_back({h.effect, h.joint + 1, e.p_value,
                                 "other findings explain it once their constants are refined"});
    } else if (e.absorbed) {
      const bool moves = !columns_of(asked_data_, h).empty();
      d.cannot_tell.push_back(
          {h.effect, h.joint + 1,
           moves ? "its torque is a combination of parameters that the model has already"
                 : "it never acts in these recordings"});
      if (h.body >= 0)
        d.cannot_tell.back().why += " (" + place_text(asked_.augmented.model, h) + ")";
    } else if (d.not_supported.size() < kListed) {
      d.not_supported.push_back({h.effect, h.joint + 1, e.p_value, why_not(e, limits_)});
    }
  }
  if (!changes_) {
    d.cannot_tell.push_back(
        {"payload", 0, "without a model from before, a load is part of the link it sits on"});
  }
}

Model FindingWriter::extended_arm() const {
  std::vector<FoundCause> found;
  for (size_t k = 0; k < selection_.accepted.size(); ++k) {
    const Hypothesis& h = accepted(k);
    found.push_back(
        {h, h.body >= 0 ? EffectTerm() : term_of(q_, h), values_of(h), payloads_[k].phi});
  }
  return veridyn::extended_arm(*start_.model, found, changes_);
}

}  // namespace veridyn
