#pragma once

#include <vector>

#include "diagnosis/evidence/normal_blocks.hpp"
#include "identification/hold_out.hpp"
#include "veridyn/diagnosis/thresholds.hpp"

namespace veridyn {

HoldOut hold_out(const Thresholds& limits);

/// Clusters that are held out together: whole recordings; parts of each where they are few (the others may
/// move too little to predict a whole one); or the phases of the period of a single one.
std::vector<std::vector<int>> make_folds(const NormalBlocks& data, const HoldOut& hold_out);

/// Sums over the clusters.
NormalBlocks::Sums summed(const NormalBlocks& data, const std::vector<int>& clusters);

/// Inverse of the mean square residual of every joint, iterated.
VectorXd joint_weights(const NormalBlocks& data, const ColumnSet& set);

/// Fall of the sum over joints of ln(mean square). The error of a joint without torque is an infinite share of it, before
/// and after, and counts for nothing.
double log_fall(const VectorXd& before, const VectorXd& after);

/// Mean over the held-out folds of that fall, from one model of the same recordings to another.
double fold_gain(const NormalBlocks& before, const ColumnSet& base_before,
                 const NormalBlocks& after, const ColumnSet& base_after, const HoldOut& hold_out);

}  // namespace veridyn
