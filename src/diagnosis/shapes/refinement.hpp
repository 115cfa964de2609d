#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/shapes/candidate_data.hpp"

namespace veridyn {

/// The accepted hypotheses fitted alone: hypothesis k is the k-th accepted one, with its constants
/// refined.
struct Fit {
  CandidateData candidate_data;
  std::optional<NormalBlocks> data;
  Selection selection;
};

/// Fits the accepted hypotheses together, their shape constants refined (see refine_shapes()). What
/// is then no longer needed (a second memory that made up for the wrong distance of the first)
/// leaves `selection`.
Fit fit_accepted(const Identification& start, const CandidateData& asked, Selection& selection,
                 bool changes, const std::vector<std::string>& train,
                 const std::vector<std::string>& test, const DiagnosisOptions& options);

/// The best rival of every accepted hypothesis, refuted or not, that has shape constants: refined
/// in its place. A cause with refined constants against one from a coarse grid is no fair
/// comparison.
std::vector<std::pair<Hypothesis, EffectTerm>> refined_rivals(
    const Identification& start, const CandidateData& asked, const Selection& selection, bool changes,
    const std::vector<std::string>& train, const IdentificationOptions& how);

}  // namespace veridyn
