#pragma once

#include <vector>

#include "diagnosis/evidence/hypotheses.hpp"
#include "diagnosis/evidence/normal_blocks.hpp"
#include "veridyn/diagnosis/payload.hpp"

namespace veridyn {

/// What may have changed together with a load.
enum class BesideLoad { kFriction, kNothing };

/// Fits a point mass to the columns of one payload hypothesis, beside changes of friction and
/// offset of the joints that carry it, or beside nothing.
PayloadEstimate fit_payload(const AugmentedModel& asked, const NormalBlocks& data,
                            const Hypothesis& payload, BesideLoad beside = BesideLoad::kFriction);

/// Columns of what may have changed with a load: offset, Coulomb and viscous friction of the joints
/// that carry it; growing sets, the first one empty.
std::vector<ColumnSet> nuisance_sets(const AugmentedModel& asked, const NormalBlocks& data,
                                     FrameIndex frame);

/// Share of the squares explained by ten free parameters of a payload that a point mass within the
/// hypothesis' reach explains as well; 0 to 1. It separates a load from a rotor's inertia or a
/// wrong gravity, which need unphysical parameters.
/// @param beside   columns that are fitted with it.
/// @param weights  of the joints.
double compact_share(const NormalBlocks& data, const Hypothesis& payload, const ColumnSet& beside,
                     const VectorXd& weights);

/// True if the columns of two payloads span the same torques.
bool same_torques(const NormalBlocks& data, const Hypothesis& a, const Hypothesis& b);

}  // namespace veridyn
