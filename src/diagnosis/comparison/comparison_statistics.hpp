#pragma once

#include "veridyn/diagnosis/model_comparison.hpp"

namespace veridyn {

/// Rule for combining the scatters of two models.
struct ClusterStatistics {
  int clusters_before, clusters_after;  ///< 0: no statistics, the model counts as exact
  bool paired;  ///< the same motion: model errors in a phase of it are common to both
};

/// Sets the members from `difference` to `p_value`, from before, after and their scatters.
void add_statistics(const VectorXd& scatter_before, const VectorXd& scatter_after,
                    const ClusterStatistics& how, ModelDifference& d);

/// Holm's correction over all numbers compared; a joint's number with same_as shares the correction
/// of its parameter.
void correct_for_number(ModelComparison& comparison);

}  // namespace veridyn
