#pragma once

#include <vector>

#include "diagnosis/evidence/examiner.hpp"

namespace veridyn {

struct Accepted {
  Evidence evidence;
  std::vector<Evidence> rivals{};   ///< other candidates that explain as much, the best of each
  /// Apparent rivals that leave a part unexplained which this one explains.
  std::vector<Evidence> refuted{};
};

/// Confidence interval of a shape constant of an accepted hypothesis.
struct ShapeInterval {
  int hypothesis = 0;
  std::string shape;
  double low = 0.0;
  double high = 0.0;
};

struct Selection {
  std::vector<Accepted> accepted;    ///< in order of discovery
  std::vector<Evidence> last_evaluated;  ///< Evidence of every hypothesis beside the accepted ones
  ColumnSet columns;                 ///< base columns and those of the accepted
  VectorXd values;                   ///< unscaled, over `columns`
  VectorXd standard_deviations;      ///< cluster jackknife
  double degrees_of_freedom = 0.0;
  std::vector<ShapeInterval> shapes;
};

/// Forward selection with swaps; superfluous hypotheses are dropped at the end, and those that they
/// concealed are tested again, until nothing changes. Weights follow the residual.
///
/// @param base     columns that are always there (independent ones).
/// @param initial  hypotheses that are accepted to begin with; they may be swapped and dropped.
Selection select_effects(const NormalBlocks& data, const ColumnSet& base,
                         const std::vector<Hypothesis>& hypotheses, const DiagnosisOptions& options,
                         const std::vector<int>& initial = {});

/// Fits the same hypotheses, all of them accepted, again with other columns.
Selection refit(const NormalBlocks& data, const ColumnSet& base,
                const std::vector<Hypothesis>& hypotheses, const DiagnosisOptions& options);

/// Drops, one after the other, accepted hypotheses whose gain or significance beside the others is
/// too small; the largest gain first in the result.
Selection keep_needed(const NormalBlocks& data, const ColumnSet& base,
                      const std::vector<Hypothesis>& hypotheses, const DiagnosisOptions& options);

/// Indices, ascending, of the accepted hypotheses that these columns still support beside the
/// others, after dropping the weakest one after the other.
std::vector<int> still_needed(const NormalBlocks& data, const ColumnSet& base,
                              const std::vector<Hypothesis>& hypotheses,
                              const DiagnosisOptions& options);

}  // namespace veridyn
