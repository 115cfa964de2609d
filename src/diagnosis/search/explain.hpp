#pragma once

#include "diagnosis/search/search.hpp"
#include "diagnosis/preparation/diagnosis_state.hpp"

namespace veridyn::search {

/// Searches for what the arm of x.start lacks and writes it down: findings, the extended model, moments in which something
/// pushed the arm, and a verdict on every joint.
void explain(DiagnosisState& x);

/// A finding of a term, with values, intervals and words.
Finding finding_of(const Chosen& chosen, const SearchResult& found, const Model& before);

/// The arm with terms of a set. Values are written where those of the arm are facts; else an identification gives them.
Model extended_arm(const Model& arm, const std::vector<Chosen>& chosen, bool changes);

}  // namespace veridyn::search
