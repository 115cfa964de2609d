#include "findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "diagnosis/evidence/effect_facts.hpp"
#include "diagnosis/causes/extended_arm.hpp"
#include "diagnosis/evidence/payload_fit.hpp"
#include "diagnosis/evidence/held_out.hpp"
#include "diagnosis/findings/finding_words.hpp"
#include "diagnosis/evidence/numerics.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "math/student_t.hpp"
#include "veridyn/effects/effect_facts.hpp"

namespace veridyn {
namespace {

// Why a hypothesis that these data can answer was not accepted.
std::string why_not(const Evidence& e, const DiagnosisOptions& limits) {
  if (e.infeasible_sign) return "its value would have an impossible sign or size";
  if (e.gain <= 0.0) return "held-out data are predicted no better";
  if (e.gain <= limits.thresholds.smallest_gain) return "held-out data gain too little from it";
  if (!e.consistent) return "it helps in some of the held-out parts only";
  return "its value is not certain enough among so many questions";
}

}  // namespace

FindingWriter::FindingWriter(const CandidateData& asked, const NormalBlocks& asked_data,
                             const Selection& selection, const Fit& fit,
                             const Identification& start, bool changes,
                             const DiagnosisOptions& limits)
    : asked_(asked),
      asked_data_(asked_data),
      selection_(selection),
      fit_(fit),
      q_(fit.candidate_data),
      data_(*fit.data),
      start_(start),
      changes_(changes),
      limits_(limits) {
  for (const Hypothesis& h : q_.augmented.hypotheses)
    payloads_.push_back(is_load(h) ? fit_payload(asked_.augmented, asked_data_, asked_hypothesis(h))
                                    : PayloadEstimate());
}

const Hypothesis& FindingWriter::accepted(size_t k) const {
  return q_.augmented.hypotheses[k];
}

// The same payload among all tested hypotheses, which have columns for accompanying changes.
const Hypothesis& FindingWriter::asked_hypothesis(const Hypothesis& h) const {
  return *std::find_if(asked_.augmented.hypotheses.begin(), asked_.augmented.hypotheses.end(),
                       [&h](const Hypothesis& other) { return same_candidate(other, h); });
}

std::vector<double> FindingWriter::values_of(const Hypothesis& h) const {
  std::vector<double> out;
  for (const std::string& name : h.columns) {
    double value = 0.0;
    for (size_t k = 0; k < fit_.selection.columns.size(); ++k) {
      if (data_.names()[fit_.selection.columns[k]] == name)
        value = fit_.selection.values[static_cast<Eigen::Index>(k)];
    }
    out.push_back(value);
  }
  return out;
}

std::vector<FoundParameter> FindingWriter::payload_parameters(const Hypothesis& h) const {
  for (size_t k = 0; k < payloads_.size(); ++k) {
    if (&accepted(k) == &h) return load_parameters(payloads_[k]);
  }
  return {};
}

// A change is no better known than what it is a change of.
double FindingWriter::own_deviation(const Hypothesis& h, const std::string& parameter) const {
  if (!is_change(h)) return 0.0;
  const EffectTerm& own = q_.augmented.model.effects()[h.own->value];
  const auto found = own.deviations.find(parameter);
  return found == own.deviations.end() || !std::isfinite(found->second) ? 0.0 : found->second;
}

std::vector<FoundParameter> FindingWriter::parameters_of(const Hypothesis& h) const {
  if (is_load(h)) return payload_parameters(h);
  const EffectTerm& term = term_of(q_.augmented.model, h);
  const std::vector<StandardParameter> all = standard_parameters(q_.augmented.model);
  const double t = student_t_quantile(numerics::kOutside, fit_.selection.degrees_of_freedom);
  const auto index = static_cast<int>(std::get<TermIndex>(h.part).value);
  std::vector<FoundParameter> out;
  for (const StandardParameter& parameter : all) {
    if (parameter.effect != index) continue;
    const auto at = static_cast<size_t>(parameter.component);
    const std::string name = find_effect(term.effect).parameters()[at].name;
    FoundParameter found{name, parameter.unit, 0.0, 0.0, 0.0};
    for (size_t k = 0; k < fit_.selection.columns.size(); ++k) {
      if (data_.names()[fit_.selection.columns[k]] != parameter.name) continue;
      const auto column = static_cast<Eigen::Index>(k);
      found.value = fit_.selection.values[column];
      const double half =
          t * std::hypot(fit_.selection.standard_deviations[column], own_deviation(h, name));
      found.low = found.value - half;
      found.high = found.value + half;
    }
    out.push_back(found);
  }
  const bool slides = is_prismatic(q_.augmented.model, term.axis);
  for (const EffectShape& shape : find_effect(term.effect).shapes()) {
    const auto value = term.values.find(shape.name);
    if (value == term.values.end()) continue;
    // Constants that were not searched (such as the origin of a slope) are no findings.
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
  const EffectTerm& own = q_.augmented.model.effects()[h.own->value];
  std::string words = own.effect;
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

std::string FindingWriter::phrase_of(const Hypothesis& h) const {
  const Model& arm = q_.augmented.model;
  const std::vector<double> values = values_of(h);
  if (is_channel(h)) return channel_phrase(arm, term_of(arm, h), values);
  return EffectFacts(arm, term_of(arm, h)).phrase(values);
}

std::string FindingWriter::phrase_of(const Group& group, const Finding& f) const {
  const Hypothesis& h = accepted(group.front());
  if (is_load(h)) return load_phrase(f.parameters);
  if (is_other_constant(h))
    return phrase_of(h) + ". The model has this effect, and its file another constant";
  if (is_change(h)) return change_text(h, f);
  if (is_channel(h)) return phrase_of(h);
  std::string out = phrase_of(h);
  for (size_t k = 1; k < group.size(); ++k) out += "; " + phrase_of(accepted(group[k]));
  if (group.size() > 1)
    out += fmt::format(" (one effect with a spectrum of {} constants)", group.size());
  return out;
}

// Hypotheses of one candidate that were accepted with several constants are one finding.
std::vector<FindingWriter::Group> FindingWriter::groups() const {
  std::vector<Group> out;
  std::map<Candidate, size_t> of_candidate;
  for (size_t k = 0; k < selection_.accepted.size(); ++k) {
    const auto [found, is_new] = of_candidate.emplace(accepted(k), out.size());
    if (is_new) out.emplace_back();
    out[found->second].push_back(k);
  }
  return out;
}

// Root mean square of every joint over the folds, each predicted from the others.
VectorXd FindingWriter::fold_error(const ColumnSet& set, const VectorXd& w) const {
  VectorXd sum = VectorXd::Zero(data_.joints());
  for (const std::vector<int>& fold : make_folds(data_, hold_out(limits_.thresholds))) {
    const NormalBlocks::Sums held_out = summed(data_, fold);
    sum += data_.residual2(set, data_.solve(set, w, data_.total(), &held_out), held_out);
  }
  return (sum.array() / data_.total().b2.array().max(numerics::kTiny)).sqrt();
}

// On every row of the held-out recordings, relative to what `start` shows; and on the folds.
std::vector<FindingWriter::Step> FindingWriter::errors_along_the_way() const {
  std::vector<Step> out;
  std::optional<NormalBlocks> test;
  if (!q_.test.empty()) test.emplace(q_.test, q_.columns, data_.scale());
  ColumnSet set = q_.base;
  VectorXd first;
  const std::vector<Group> all = groups();
  for (size_t k = 0; k <= all.size(); ++k) {
    const VectorXd w = joint_weights(data_, set);
    out.push_back({{}, fold_error(set, w)});
    if (test) {
      const VectorXd x = data_.solve(set, w, data_.total(), nullptr);
      const VectorXd r2 = test->residual2(set, x, test->total());
      if (k == 0) first = r2;
      out.back().test = start_.test_error.relative.array() *
                        (r2.array() / first.array().max(numerics::kTiny)).sqrt();
    }
    if (k == all.size()) break;
    for (const size_t member : all[k]) {
      const ColumnSet own = columns_of(data_, accepted(member));
      set.insert(set.end(), own.begin(), own.end());
    }
  }
  return out;
}

Finding FindingWriter::finding(const Group& group, const Step& before, const Step& after) const {
  const Hypothesis& h = accepted(group.front());
  Finding f = finding_at(h);
  f.test_before = before.test;
  f.test_after = after.test;
  f.folds_before = before.folds;
  f.folds_after = after.folds;
  for (size_t k = 0; k < group.size(); ++k) {
    const Accepted& a = selection_.accepted[group[k]];
    for (FoundParameter& p : parameters_of(accepted(group[k]))) {
      if (k > 0) p.name += fmt::format("_{}", k + 1);
      f.parameters.push_back(std::move(p));
    }
    f.p_value = std::min(f.p_value, a.evidence.p_value);
    f.gain = std::max(f.gain, a.evidence.gain);
    const Hypothesis& asked = asked_hypothesis(accepted(group[k]));
    for (Rival& r : rivals_of(asked_, asked_data_, asked, a, changes_)) {
      const bool known =
          std::any_of(f.rivals.begin(), f.rivals.end(),
                      [&r](const Rival& other) { return alike(other.cause, r.cause); });
      if (!alike(r.cause, f.cause) && !known) f.rivals.push_back(std::move(r));
    }
  }
  if (!f.parameters.empty()) f.unit = f.parameters.front().unit;
  f.phrase = phrase_of(group, f);
  if (is_channel(h)) f.remark = remark_on_size(h, values_of(h));
  f.status = status_of(f);
  return f;
}

void FindingWriter::add_findings(Diagnosis& d) const {
  const std::vector<Step> errors = errors_along_the_way();
  const std::vector<Group> all = groups();
  for (size_t k = 0; k < all.size(); ++k) {
    Finding f = finding(all[k], errors[k], errors[k + 1]);
    f.rank = static_cast<int>(d.findings.size()) + 1;
    f.explains = explained_share(f.test_before, f.test_after, d.baseline);
    d.findings.push_back(std::move(f));
  }
}

std::vector<std::vector<std::string>> FindingWriter::parameter_names() const {
  std::vector<std::vector<std::string>> out;
  for (const Group& group : groups()) {
    out.emplace_back();
    for (const size_t k : group)
      out.back().insert(out.back().end(), accepted(k).columns.begin(), accepted(k).columns.end());
  }
  return out;
}

std::vector<char> FindingWriter::own_constants() const {
  std::vector<char> out;
  for (const Group& group : groups()) out.push_back(is_other_constant(accepted(group.front())) ? 1 : 0);
  return out;
}

void FindingWriter::add_the_rest(Diagnosis& d) const {
  std::set<Candidate> known;
  for (size_t k = 0; k < selection_.accepted.size(); ++k) known.insert(accepted(k));
  std::vector<Evidence> rest = selection_.last_evaluated;
  const auto rank = [](const Evidence& e) { return e.accepted ? 0 : e.collinear ? 2 : 1; };
  std::stable_sort(rest.begin(), rest.end(), [&rank](const Evidence& a, const Evidence& b) {
    return rank(a) != rank(b) ? rank(a) < rank(b) : a.gain > b.gain;
  });
  for (const Evidence& e : rest) {
    const Hypothesis& h = asked_.augmented.hypotheses[e.hypothesis];
    if (!known.insert(h).second || is_other_constant(h)) continue;
    if (e.accepted) {
      d.not_supported.push_back({h.cause, e.p_value,
                                 "other findings explain it once their constants are refined"});
    } else if (e.collinear) {
      const bool moves = !columns_of(asked_data_, h).empty();
      d.cannot_tell.push_back(
          {effect_of(h.cause), h.cause,
           moves ? "its torque is a combination of parameters that the model has already"
                 : "it never acts in these recordings"});
      if (is_load(h)) {
        d.cannot_tell.back().why +=
            " (on " + words_of(asked_.augmented.model, h.cause).frame + ")";
      }
    } else if (d.not_supported.size() < numerics::kListed) {
      d.not_supported.push_back({h.cause, e.p_value, why_not(e, limits_)});
    }
  }
  if (!changes_) {
    d.cannot_tell.push_back({AddedLoad::kName, std::nullopt,
                             "without a model from before, a load is part of the link it sits on"});
  }
}

bool FindingWriter::fit_load_alone(size_t k, Finding& f) {
  const Group group = groups()[k];
  const Hypothesis& h = accepted(group.front());
  if (!is_load(h)) return false;
  payloads_[group.front()] =
      fit_payload(asked_.augmented, asked_data_, asked_hypothesis(h), BesideLoad::kNothing);
  f.parameters = known_to_both(payload_parameters(h), f.parameters);  // friction may have changed
  f.phrase = phrase_of(group, f);
  return true;
}

Model FindingWriter::extended_arm_of(const std::vector<size_t>& chosen) const {
  std::vector<FoundCause> found;
  for (const size_t k : chosen) {
    const Hypothesis& h = accepted(k);
    found.push_back(
        {h, is_load(h) ? EffectTerm() : term_of(q_.augmented.model, h), values_of(h),
         payloads_[k].phi});
  }
  return veridyn::extended_arm(*start_.model, found, changes_);
}

Model FindingWriter::extended_arm() const {
  std::vector<size_t> all(selection_.accepted.size());
  std::iota(all.begin(), all.end(), size_t{0});
  return extended_arm_of(all);
}

Model FindingWriter::extended_arm(const std::set<size_t>& kept) const {
  std::vector<size_t> chosen;
  const std::vector<Group> all = groups();
  for (const size_t k : kept) chosen.insert(chosen.end(), all[k].begin(), all[k].end());
  return extended_arm_of(chosen);
}

}  // namespace veridyn
