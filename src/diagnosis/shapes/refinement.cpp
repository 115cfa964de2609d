#include "diagnosis/shapes/refinement.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "diagnosis/shapes/shape_search.hpp"

namespace veridyn {
namespace {

// Two terms of one candidate whose constants lie near each other.
std::optional<size_t> second_twin(const CandidateData& asked, const Selection& selection,
                                  double near_duplicate) {
  const auto hypothesis = [&](size_t k) -> const Hypothesis& {
    return asked.augmented
        .hypotheses[selection.accepted[k].evidence.hypothesis];
  };
  for (size_t second = 1; second < selection.accepted.size(); ++second) {
    for (size_t first = 0; first < second; ++first) {
      const Hypothesis& a = hypothesis(first);
      const Hypothesis& b = hypothesis(second);
      if (!same_candidate(a, b) || is_load(a)) continue;
      const auto& others = term_of(asked.augmented.model, b).values;
      bool near = true;
      for (const auto& [key, value] : term_of(asked.augmented.model, a).values) {
        const auto other = others.find(key);
        if (other == others.end() || value <= 0.0) continue;
        near = near && std::abs(std::log(other->second / value)) < std::log(near_duplicate);
      }
      if (near) return second;
    }
  }
  return std::nullopt;
}

ColumnSet all_columns(const CandidateData& q, const NormalBlocks& data) {
  ColumnSet set = q.base;
  for (const Hypothesis& h : q.augmented.hypotheses) {
    const ColumnSet own = columns_of(data, h);
    set.insert(set.end(), own.begin(), own.end());
  }
  return set;
}

// Two memories of one joint at adjacent grid values may be a single one in between: one is dropped
// if the other, refined alone, predicts held-out data as well.
void merge_twins(const Identification& start, const CandidateData& asked, Selection& selection,
                 bool changes, const std::vector<std::string>& train,
                 const DiagnosisOptions& options) {
  const IdentificationOptions& how = options.identification;
  const auto refined = [&](const Selection& s) {
    return prepare(start, refine_shapes(start, asked, s, changes, train, how).model, changes, train,
                   {}, how);
  };
  std::optional<CandidateData> two;
  while (const std::optional<size_t> second = second_twin(asked, selection, options.thresholds.near_duplicate)) {
    if (!two) two.emplace(refined(selection));
    Selection merged = selection;
    merged.accepted.erase(merged.accepted.begin() + static_cast<long>(*second));
    CandidateData one = refined(merged);
    const NormalBlocks two_data(two->train, two->columns);
    const NormalBlocks one_data(one.train, one.columns);
    if (fold_gain(one_data, all_columns(one, one_data), two_data, all_columns(*two, two_data),
                  hold_out(options.thresholds)) >
        options.thresholds.smallest_gain)
      return;
    selection = std::move(merged);
    two.emplace(std::move(one));
  }
}

// The best challenger of an accepted hypothesis that has constants of its own and no part yet.
const Evidence* challenger(const CandidateData& asked, const Accepted& a, const std::set<int>& taken) {
  const Evidence* best = nullptr;
  for (const auto* list : {&a.rivals, &a.refuted}) {
    for (const Evidence& e : *list) {
      const Hypothesis& h = asked.augmented.hypotheses[e.hypothesis];
      if (!has_searched_shape(asked, h) || taken.count(e.hypothesis) != 0) continue;
      if (best == nullptr || best->gain < e.gain) best = &e;
    }
  }
  return best;
}

}  // namespace

Fit fit_accepted(const Identification& start, const CandidateData& asked, Selection& selection,
                 bool changes, const std::vector<std::string>& train,
                 const std::vector<std::string>& test, const DiagnosisOptions& options) {
  const IdentificationOptions& how = options.identification;
  std::optional<Fit> fit;
  std::vector<Shapes> known;
  merge_twins(start, asked, selection, changes, train, options);
  while (true) {
    const RefinedShapes refined =
        refine_shapes(start, asked, selection, changes, train, how, known);
    fit.emplace(Fit{prepare(start, refined.model, changes, train, test, how), std::nullopt, {}});
    fit->data.emplace(fit->candidate_data.train, fit->candidate_data.columns);
    const std::vector<Hypothesis>& hypotheses = fit->candidate_data.augmented.hypotheses;
    const std::vector<int> needed =
        refined.anything ? still_needed(*fit->data, fit->candidate_data.base, hypotheses, options)
                         : std::vector<int>();
    if (!refined.anything || needed.size() == hypotheses.size()) {
      fit->selection = refit(*fit->data, fit->candidate_data.base, hypotheses, options);
      fit->selection.shapes = shape_intervals(start, asked, selection, changes, train, how, refined.shapes);
      return std::move(*fit);
    }
    std::vector<Accepted> kept;
    known.clear();
    for (const int k : needed) {
      kept.push_back(selection.accepted[k]);
      known.push_back(refined.shapes[k]);
    }
    selection.accepted = std::move(kept);
  }
}

std::vector<std::pair<Hypothesis, EffectTerm>> refined_rivals(
    const Identification& start, const CandidateData& asked, const Selection& selection, bool changes,
    const std::vector<std::string>& train, const IdentificationOptions& how) {
  Selection swapped = selection;
  std::set<int> taken;
  for (const Accepted& a : selection.accepted) taken.insert(a.evidence.hypothesis);
  std::vector<size_t> places;
  for (size_t k = 0; k < selection.accepted.size(); ++k) {
    const Evidence* other = challenger(asked, selection.accepted[k], taken);
    if (other == nullptr) continue;
    taken.insert(other->hypothesis);
    swapped.accepted[k].evidence.hypothesis = other->hypothesis;
    places.push_back(k);
  }
  std::vector<std::pair<Hypothesis, EffectTerm>> out;
  if (places.empty()) return out;
  const AugmentedModel refined = refine_shapes(start, asked, swapped, changes, train, how).model;
  for (const size_t k : places) {
    const Hypothesis& h = refined.hypotheses[k];
    out.emplace_back(h, term_of(refined.model, h));
  }
  return out;
}

}  // namespace veridyn
