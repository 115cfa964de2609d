#pragma once

#include <vector>

#include "diagnosis/evidence/examiner.hpp"

namespace veridyn {

struct Accepted {
  Evidence evidence;
  std::vector<Evidence> rivals{};   ///< other candidates that explain as much, the best of each
  std::vector<Evidence> refuted{};  ///< Rivals in appearance, which leave something that this one explains
};

/// Where a shape constant of an accepted hypothesis may lie.
struct ShapeInterval {
  int hypothesis = -1;
  std::string shape;
  double low = 0.0;
  double high = 0.0;
};

struct Selection {
  std::vector<Accepted> accepted;    ///< in order of discovery
  std::vector<Evidence> last_asked;  ///< Evidence of every hypothesis beside the accepted ones
  ColumnSet columns;                 ///< base columns and those of the accepted
  VectorXd values;                   ///< unscaled, over `columns`
  VectorXd standard_deviations;      ///< cluster jackknife
  double degrees_of_freedom = 0.0;
  std::vector<ShapeInterval> shapes;
};

/// Forward selection with swaps; what is superfluous in the end goes, and what it hid is asked again,
/// until nothing changes. Weights follow the residual.
///
/// @param base     columns that are always there (independent ones).
/// @param initial  hypotheses that are accepted to begin with; they may be swapped and dropped.
Selection select_effects(const NormalBlocks& data, const ColumnSet& base,
                         const std::vector<Hypothesis>& hypotheses, const DiagnosisOptions& options,
                         const std::vector<int>& initial = {});

/// The same hypotheses, all of them accepted, fitted again: for other columns of theirs.
Selection refit(const NormalBlocks& data, const ColumnSet& base,
                const std::vector<Hypothesis>& hypotheses, const DiagnosisOptions& options);

/// Of hypotheses that are all accepted, those that stay when what gains too little or is not certain
/// beside the others goes, one after the other; the largest gain first.
Selection keep_needed(const NormalBlocks& data, const ColumnSet& base,
                      const std::vector<Hypothesis>& hypotheses, const DiagnosisOptions& options);

/// Of hypotheses that are all accepted, those that these columns no longer support beside the
/// others, one after the other, the weakest first. Indices that stay, ascending.
std::vector<int> still_needed(const NormalBlocks& data, const ColumnSet& base,
                              const std::vector<Hypothesis>& hypotheses,
                              const DiagnosisOptions& options);

}  // namespace veridyn
