#pragma once

#include <vector>

#include "inquiry.hpp"
#include "veridyn/diagnosis/payload.hpp"

namespace veridyn {

/// Fits a point mass to the columns of one payload hypothesis, beside changes of friction and
/// offset of the joints that carry it.
PayloadEstimate fit_payload(const Inquiry& inquiry, const NormalBlocks& data,
                            const Hypothesis& payload);

/// Columns of what may have changed with a load: offset, Coulomb and viscous friction of the joints
/// that carry it; growing sets, the first one empty.
std::vector<ColumnSet> nuisance_sets(const Inquiry& inquiry, const NormalBlocks& data, int frame);

/// True if the columns of two payloads span the same torques.
bool same_torques(const NormalBlocks& data, const Hypothesis& a, const Hypothesis& b);

}  // namespace veridyn
