#include "diagnosis/shapes/refinement.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "diagnosis/shapes/shape_search.hpp"

namespace veridyn {
namespace {

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
