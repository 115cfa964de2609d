#pragma once

#include <optional>
#include <string>
#include <vector>

#include "inquiry.hpp"

namespace veridyn {

/// What was accepted, fitted alone: hypothesis k is the k-th accepted one, with its constants
/// refined.
struct Fit {
  Inquiry inquiry;
  std::optional<NormalBlocks> data;
  Selection selection;
};

/// Fits the accepted hypotheses together. Their shape constants (a presliding distance, a Stribeck
/// velocity), so far from a coarse grid, are refined by variable projection: the recordings are
/// streamed again with a few values around, and every constant descends to the least weighted
/// residual. What is then no longer needed (a second memory that made up for the wrong distance of
/// the first) leaves `selection`.
Fit fit_accepted(const Identification& start, const Inquiry& asked, Selection& selection,
                 bool changes, const std::vector<std::string>& train,
                 const std::vector<std::string>& test, const DiagnosisOptions& options);

}  // namespace veridyn
