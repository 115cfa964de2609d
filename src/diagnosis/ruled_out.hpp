#pragma once

#include <map>
#include <string>

#include "inquiry.hpp"
#include "refinement.hpp"

namespace veridyn {

/// One line in d.not_supported or d.cannot_tell for every family that was asked and not accepted.
///
/// @param asked        all hypotheses, with the factors of their columns and what was selected.
/// @param fit          the accepted ones.
/// @param unconfirmed  families that were accepted until the held-out recordings spoke, with their
///                     p values.
void add_ruled_out(const Inquiry& asked, const NormalBlocks& asked_data, const Selection& selection,
                   const Fit& fit, const std::map<std::string, double>& unconfirmed,
                   const DiagnosisOptions& limits, Diagnosis& d);

}  // namespace veridyn
