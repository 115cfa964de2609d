#pragma once

#include "veridyn/diagnosis/model_comparison.hpp"

namespace veridyn {

/// Rule for combining the scatters of two models.
struct ClusterStatistics {
  int clusters_before, clusters_after;  ///< 0: no statistics, the model counts as exact
  bool paired;  ///< the same motion: errors of the model at one phase occur in both
};

/// Sets the statistics of a difference, from `difference` to `p_value`, by its values and their scatters.
void add_statistics(const VectorXd& scatter_before, const VectorXd& scatter_after,
                    const ClusterStatistics& how, ModelDifference& d);

/// Holm's correction over all compared numbers. A joint's number with same_as is corrected together with its
/// parameter.
void correct_for_number(ModelComparison& comparison);

}  // namespace veridyn
