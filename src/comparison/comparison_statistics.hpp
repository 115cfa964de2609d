#pragma once

#include "veridyn/comparison/model_comparison.hpp"

namespace veridyn {

/// How the scatters of two models combine.
struct ClusterStatistics {
  int clusters_before, clusters_after;  ///< 0: no statistics, the model counts as exact
  bool paired;  ///< the same motion: what the model gets wrong in one phase of it is common to both
};

/// Fills in everything from `difference` to `p_value`, from before, after and their scatters.
void add_statistics(const VectorXd& scatter_before, const VectorXd& scatter_after,
                    const ClusterStatistics& how, ModelDifference& d);

/// Holm's correction over all numbers compared; a joint's number with same_as takes that of its
/// parameter.
void correct_for_number(ModelComparison& comparison);

}  // namespace veridyn
