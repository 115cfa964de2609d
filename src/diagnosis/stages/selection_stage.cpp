#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include "diagnosis/causes/ripple.hpp"
#include "diagnosis/evidence/folds.hpp"
#include "diagnosis/evidence/held_out.hpp"
#include "diagnosis/evidence/effect_facts.hpp"
#include "diagnosis/findings/finding_words.hpp"
#include "diagnosis/findings/findings.hpp"
#include "diagnosis/findings/right_to_a_name.hpp"
#include "diagnosis/shapes/refinement.hpp"
#include "diagnosis/stages/channel_correction.hpp"
#include "diagnosis/stages/diagnosis_state.hpp"
#include "diagnosis/stages/newly_visible.hpp"
#include "diagnosis/findings/next_experiment.hpp"
#include "veridyn/effects/effect_facts.hpp"

namespace veridyn {
namespace {

// One round of tests with the accepted hypotheses.
struct Round : CandidateTests {
  Selection selection;
  bool changed = true;  // the selection differs from the initial one
};

std::vector<std::pair<Hypothesis, EffectTerm>> known_terms(const AugmentedModel& fitted) {
  std::vector<std::pair<Hypothesis, EffectTerm>> out;
  for (const Hypothesis& h : fitted.hypotheses) {
    if (!is_load(h)) out.emplace_back(h, term_of(fitted.model, h));
  }
  return out;
}

// Indices of the fitted hypotheses in a longer list that begins with them.
std::vector<int> same_ones(const AugmentedModel& fitted, const CandidateData& q) {
  std::vector<int> out;
  for (const Hypothesis& h : fitted.hypotheses) {
    for (size_t k = 0; k < q.augmented.hypotheses.size(); ++k) {
      if (!same_candidate(q.augmented.hypotheses[k], h)) continue;
      if (std::find(out.begin(), out.end(), static_cast<int>(k)) != out.end()) continue;
      out.push_back(static_cast<int>(k));
      break;
    }
  }
  return out;
}

DiagnosisOptions for_the_rest(const DiagnosisState& x) {
  DiagnosisOptions out = x.options;
  out.max_effects = x.names_left();
  return out;
}

// `accepted`: to begin with; their terms are among those that the questions know.
Round answer(const DiagnosisState& x, CandidateTests asked, const AugmentedModel* accepted = nullptr) {
  const CandidateData& q = asked.q;
  const std::vector<int> initial =
      accepted == nullptr ? std::vector<int>() : same_ones(*accepted, q);
  Selection selection =
      select_effects(asked.data, q.base, q.augmented.hypotheses, for_the_rest(x), initial);
  std::vector<int> chosen;
  for (const Accepted& a : selection.accepted) chosen.push_back(a.evidence.hypothesis);
  return {std::move(asked), std::move(selection), chosen != initial};
}

Fit fitted(const DiagnosisState& x, Round& round) {
  return fit_accepted(x.start, round.q, round.selection, x.d.changes, x.train, x.test, x.options);
}

const Hypothesis& accepted(const Round& round, size_t k) {
  return round.q.augmented
      .hypotheses[round.selection.accepted[k].evidence.hypothesis];
}

// The finding of the same error of the same channel, or nullptr.
template <typename SomeDiagnosis>
auto same_channel(SomeDiagnosis& d, const Hypothesis& h) -> decltype(d.findings.data()) {
  for (auto& f : d.findings) {
    if (effect_of(f.cause) == effect_of(h.cause) && f.joint == h.joint && f.from == h.from) return &f;
  }
  return nullptr;
}

// A channel error that was accepted first, one corrected before that needs more, or one too large
// for its derivative.
std::optional<size_t> channel_to_correct(const DiagnosisState& x, const Round& round) {
  for (size_t k = 0; k < round.selection.accepted.size(); ++k) {
    const Hypothesis& h = accepted(round, k);
    if (!is_channel(h)) continue;
    if (k == 0 || same_channel(x.d, h) != nullptr) return k;
    const Selection alone = refit(round.data, round.q.base, {h}, x.options);
    const size_t own = columns_of(round.data, h).size();
    for (size_t p = alone.columns.size() - own; p < alone.columns.size(); ++p) {
      if (std::abs(alone.values[static_cast<Eigen::Index>(p)]) > h.largest_value) return k;
    }
  }
  return std::nullopt;
}

// A channel error beyond its usual size against a rival that explains as much: what is usual decides
// this tie, and nothing but a tie.
bool gives_way(const Accepted& a, const Thresholds& thresholds) {
  return std::any_of(a.rivals.begin(), a.rivals.end(), [&](const Evidence& rival) {
    return rival.gain > thresholds.tie * a.evidence.gain;
  });
}

// Corrects a channel error that comes first before other tests: its columns are of first order, and
// its residual would imitate other causes. True if the tests must be repeated: it was corrected, or
// the recordings refused it.
bool correct_first_channel(DiagnosisState& x, const Round& round) {
  const std::optional<size_t> at = channel_to_correct(x, round);
  if (!at) return false;
  const Hypothesis& h = accepted(round, *at);
  std::optional<CorrectedChannel> channel = correct_channel(x, round, h);
  if (!channel) {
    x.refused.insert(h);
    return true;
  }
  const Accepted& a = round.selection.accepted[*at];
  const bool unusual = std::any_of(channel->values.begin(), channel->values.end(),
                                   [&h](double value) { return std::abs(value) > h.largest_value; });
  if (unusual && (x.usual_channels_only || gives_way(a, x.options.thresholds))) {
    x.refused.insert(h);
    return true;
  }
  estimate_newly_visible(x, h, *channel);
  const VectorXd folds_before = x.fold_errors(x.start).relative();
  const VectorXd folds_after = x.fold_errors(channel->corrected).relative();
  if (Finding* earlier = same_channel(x.d, h)) {
    std::vector<double> before;
    for (const FoundParameter& p : earlier->parameters) before.push_back(p.value);
    const std::vector<double> values =
        values_so_far(*x.d.baseline.model, h, *channel, together(h, before, channel->values));
    const Finding both = channel_finding(round.q, h, values, channel->half_widths);
    earlier->parameters = both.parameters;
    earlier->phrase = both.phrase;
    earlier->remark = both.remark;
    earlier->test_after = channel->corrected.test_error.relative;
    earlier->folds_after = folds_after;
    earlier->explains = explained_share(earlier->test_before, earlier->test_after, x.d.baseline);
    earlier->status = status_of(*earlier);
    x.start = channel->corrected;
    return true;
  }
  Finding f = channel_finding(round.q, h, channel->values, channel->half_widths);
  f.test_before = x.start.test_error.relative;
  f.test_after = channel->corrected.test_error.relative;
  f.folds_before = folds_before;
  f.folds_after = folds_after;
  f.status = status_of(f);
  if (x.options.extended == ExtendedModel::kConfirmedOnly &&
      f.status == FindingStatus::kNotConfirmed) {
    x.refused.insert(h);
    x.d.not_supported.push_back({h.cause, a.evidence.p_value, "held-out parts of the training recordings contradict it"});
    return true;
  }
  f.p_value = a.evidence.p_value;
  f.gain = a.evidence.gain;
  f.rivals = rivals_of(round.q, round.data, h, a, x.d.changes);
  f.explains = explained_share(f.test_before, f.test_after, x.d.baseline);
  if (unusual && h.joint) x.unusual.push_back({h.cause, f.p_value, {}});
  x.d.findings.push_back(std::move(f));
  x.start = channel->corrected;
  return true;
}

// The accepted ones against their rivals, all with refined constants.
void challenge(const DiagnosisState& x, CandidateList& list, std::optional<Round>& round,
               std::optional<Fit>& fit) {
  const auto rivals = refined_rivals(x.start, round->q, round->selection, x.d.changes, x.train,
                                     x.options.identification);
  if (rivals.empty()) return;
  list.known = known_terms(fit->candidate_data.augmented);
  list.known.insert(list.known.end(), rivals.begin(), rivals.end());
  round.reset();
  round.emplace(answer(x, prepare_tests(x, list, x.start), &fit->candidate_data.augmented));
  if (round->changed) fit.emplace(fitted(x, *round));
}

// Updates values of effects that became part of the arm from the last fit. With values as facts nothing is fitted.
void refresh_findings(DiagnosisState& x) {
  if (x.d.changes) return;
  for (const auto& [k, names] : x.fitted_by_start) {
    if (k < x.d.findings.size()) refresh(x.d.extended, names, x.d.findings[k]);
  }
}

// The errors along the way are of fits without physical conditions. What they contradict is asked once
// more of the models themselves: with it, the error on held-out parts of the training recordings falls in
// sum and on its own joint, or not.
void ask_again(DiagnosisState& x, size_t first, size_t count,
               const std::function<Identification(const std::set<size_t>&)>& fit,
               std::set<size_t>& kept) {
  VectorXd folds;  // of the extended model
  for (size_t k = 0; k < count && x.d.extended.model; ++k) {
    Finding& f = x.d.findings[first + k];
    if (kept.count(k) != 0 || !f.joint) continue;
    std::set<size_t> more = kept;
    more.insert(k);
    Identification with = fit(more);
    if (!with.model) continue;
    if (folds.size() == 0) folds = x.fold_errors(x.d.extended).relative();
    Finding again = f;
    again.test_before = x.d.extended.test_error.relative;
    again.test_after = with.test_error.relative;
    again.folds_before = folds;
    again.folds_after = x.fold_errors(with).relative();
    again.status = status_of(again);
    if (again.status == FindingStatus::kNotConfirmed) continue;
    again.explains = explained_share(again.test_before, again.test_after, x.d.baseline);
    folds = again.folds_after;
    f = std::move(again);
    kept = std::move(more);
    x.d.extended = std::move(with);
  }
}

// Fits the kept findings and withdraws those that are then unsupported: sizes that may be zero or
// exceed their joint's torque, or a joint that is predicted better without them.
void settle(DiagnosisState& x, FindingWriter& writer, size_t first, std::set<size_t>& kept) {
  const auto names = writer.parameter_names();
  const auto fit = [&](const std::set<size_t>& some) {
    return some.empty() ? x.start : x.fit(writer.extended_arm(some));
  };
  const auto take_out = [&](size_t k, const std::string& why) {
    x.d.findings[first + k].status = FindingStatus::kNotConfirmed;
    x.d.findings[first + k].why_not = why;
    kept.erase(k);
  };
  x.d.extended = fit(kept);
  if (x.options.extended == ExtendedModel::kConfirmedOnly) ask_again(x, first, names.size(), fit, kept);
  bool loads_alone = false;  // without changes of friction beside them
  std::set<size_t> needed;  // taken out once, and the joint was no better off
  const FoldErrors baseline = x.fold_errors(x.d.baseline);
  for (int turn = 0; turn < x.options.thresholds.settling && x.d.extended.model && !kept.empty(); ++turn) {
    for (const size_t k : kept) {
      // Several sizes of one curve may trade with the arm's parameters, which are all free there.
      if (!x.d.changes && names[k].size() == 1)
        refresh(x.d.extended, names[k], x.d.findings[first + k]);
    }
    if (x.options.extended == ExtendedModel::kAllFindings) return;
    if (const std::optional<LostRight> lost = without_size(x.d, first, kept)) {
      take_out(lost->finding, lost->why);
      x.d.extended = fit(kept);
      continue;
    }
    const FoldErrors extended = x.fold_errors(x.d.extended);
    if (!loads_alone && !worse_joints(baseline, extended, x.options.thresholds).empty()) {
      loads_alone = true;
      bool any = false;
      for (const size_t k : kept) any = writer.fit_load_alone(k, x.d.findings[first + k]) || any;
      if (any) {
        x.d.extended = fit(kept);
        continue;
      }
    }
    const std::optional<LostRight> lost = worse_with(x.d, first, kept, needed, baseline, extended, x.options.thresholds);
    if (!lost) return;
    std::set<size_t> others = kept;
    others.erase(lost->finding);
    Identification without = fit(others);
    if (without.model && falls(extended.relative(), x.fold_errors(without).relative(), JointIndex{lost->joint})) {
      take_out(lost->finding, lost->why);
      x.d.extended = std::move(without);
    } else {
      needed.insert(lost->finding);
    }
  }
}

// Plain friction that is nothing once the causes are there, where held-out parts of the training recordings
// do without it.
void drop_lost_friction(DiagnosisState& x) {
  if (x.options.extended == ExtendedModel::kAllFindings || !x.d.extended.model) return;
  const Model& arm = *x.d.extended.model;
  ModelDescription description = arm.description();
  std::map<size_t, std::string> lost;
  std::set<std::string> parameters;
  for (const auto& [k, names] : x.fitted_by_start) {
    if (k >= x.d.findings.size()) continue;
    const std::string why = why_no_finding(x.d.findings[k], x.d.extended);
    if (why.empty()) continue;
    lost[k] = why;
    parameters.insert(names.front());
  }
  if (lost.empty()) return;
  auto& effects = description.effects;
  effects.erase(std::remove_if(effects.begin(), effects.end(),
                               [&](const EffectTerm& term) {
                                 return has_axis_effect(term.effect) &&
                                        parameters.count(EffectFacts(arm, term).parameter_name(0)) != 0;
                               }),
                effects.end());
  description.identified.reset();
  Identification without = x.fit(Model(std::move(description)));
  if (!without.model ||
      log_fall(x.fold_errors(x.d.extended).relative(), x.fold_errors(without).relative()) <
          -x.options.thresholds.held_out_worse)
    return;
  x.d.extended = std::move(without);
  for (const auto& [k, why] : lost) {
    x.d.findings[k].status = FindingStatus::kNotConfirmed;
    x.d.findings[k].why_not = why;
  }
}

void write_down(DiagnosisState& x, const Round& round, const Fit& fit) {
  const auto& asked = round.q.augmented.hypotheses;
  x.d.hypotheses = static_cast<int>(std::set<Candidate>(asked.begin(), asked.end()).size());
  FindingWriter writer(round.q, round.data, round.selection, fit, x.start, x.d.changes, x.options);
  const size_t first = x.d.findings.size();
  writer.add_findings(x.d);
  writer.add_the_rest(x.d);
  const std::vector<char> own = writer.own_constants();
  std::set<size_t> kept;
  for (size_t k = first; k < x.d.findings.size(); ++k) {
    if (x.options.extended == ExtendedModel::kAllFindings ||
        x.d.findings[k].status == FindingStatus::kConfirmed)
      kept.insert(k - first);
  }
  settle(x, writer, first, kept);
  for (size_t k = 0; k < own.size(); ++k) {
    if (own[k] != 0 && kept.count(k) != 0)
      x.d.remarks.push_back(sentence(x.arm, x.d.findings[first + k]));
  }
  for (size_t k = own.size(); k-- > 0;) {
    if (own[k] != 0) x.d.findings.erase(x.d.findings.begin() + static_cast<long>(first + k));
  }
  merge_corrections(x.arm, first, x.d.findings);
  refresh_findings(x);
  drop_lost_friction(x);
  x.d.next_experiment = next_experiment(x.d);
}

// One pass through all candidates.
void select(DiagnosisState& x) {
  CandidateList list = x.list();
  if (asks_for_waves(list.wanted))
    list.ripple_orders = ripple_orders(x.start, x.options.thresholds);
  std::optional<Round> round(answer(x, prepare_tests(x, list, x.start)));
  for (int turn = 0; turn < x.options.thresholds.corrected_channels && correct_first_channel(x, *round); ++turn) {
    round.reset();  // its factors, before there are others
    round.emplace(answer(x, prepare_tests(x, list, x.start)));
  }
  std::optional<Fit> fit(fitted(x, *round));
  challenge(x, list, round, fit);
  write_down(x, *round, *fit);
}

}  // namespace

// A channel error far beyond its usual size, of one joint, imitates what its torque lags behind or falls
// short of: memory, backlash, friction. It is a cause only if the others without it predict held-out parts
// worse (an encompassing test).
void select_causes(DiagnosisState& x) {
  x.unusual.clear();
  DiagnosisState usual = x;
  select(x);
  if (x.unusual.empty() || !x.d.extended.model) return;
  usual.usual_channels_only = true;
  select(usual);
  usual.usual_channels_only = false;
  if (!usual.d.extended.model ||
      log_fall(x.fold_errors(x.d.extended).relative(), usual.fold_errors(usual.d.extended).relative()) <
          -x.options.thresholds.smallest_gain)
    return;
  for (NotSupported& n : x.unusual) {
    n.why = "it is unusually large, and held-out parts are predicted as well without it";
    usual.d.not_supported.push_back(n);
  }
  x = std::move(usual);
}

}  // namespace veridyn
