#pragma once

#include <optional>
#include <vector>

#include "diagnosis/stages/diagnosis_state.hpp"

namespace veridyn {

/// The error of a channel (gain, delay, zero) or of the base (tilt) after corrections, which are
/// repeated while they lower the training error.
struct CorrectedChannel {
  Identification corrected;     ///< the arm with the error undone
  std::vector<double> values;   ///< sizes of the error
  VectorXd half_widths;         ///< Half widths of their 95 % intervals, from the last step
};

/// Columns of such an error are derivatives, valid for small errors only. Gauss-Newton steps with
/// halving extend them to large ones; the criterion is the training error of the corrected arm.
///
/// @param h      a hypothesis of asked.q that is a channel's error.
/// @returns nothing if no step lowers the training error.
std::optional<CorrectedChannel> correct_channel(const DiagnosisState& x, const CandidateTests& asked,
                                                const Hypothesis& h);

/// Sizes of an error that led from one arm to the corrected one. @param sum  of successive corrections.
std::vector<double> values_so_far(const Model& first, const Hypothesis& h, const CorrectedChannel& channel,
                                  std::vector<double> sum);

/// Two errors of one channel, one undone after the other: relative ones multiply, others add.
std::vector<double> together(const Hypothesis& h, const std::vector<double>& first,
                             const std::vector<double>& second);

/// An error of a channel that is corrected already may need a little more beside causes that came later: it is one
/// finding, with both in its values. @param first  of the later ones in `all`.
void merge_corrections(const Model& arm, size_t first, std::vector<Finding>& all);

}  // namespace veridyn
