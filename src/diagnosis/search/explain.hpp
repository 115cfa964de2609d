#pragma once

#include "diagnosis/search/search.hpp"
#include "diagnosis/preparation/diagnosis_state.hpp"

namespace veridyn::search {

/// Searches for the effects that the arm of x.start lacks and stores the result: findings, the extended
/// model, intervals in which something pushed the arm, and a verdict on every joint.
void explain(DiagnosisState& x);

/// The finding of a term, with values, intervals and words.
Finding finding_of(const Chosen& chosen, const SearchResult& found, const Model& before);

/// The arm with these terms. Their values are written if those of the arm are known; otherwise an
/// identification estimates them.
Model extended_arm(const Model& arm, const std::vector<Chosen>& chosen, bool changes);

}  // namespace veridyn::search
