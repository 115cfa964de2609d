#pragma once

#include <optional>
#include <set>

#include "diagnosis/stages/diagnosis_state.hpp"

namespace veridyn {

/// True for a name that is not asked about by default.
bool is_later(const Finding& f, const Model& arm);

/// True for a name of a force that depends on positions alone, and of an error of the whole arm (its mounting, a force
/// on its tip): these imitate one another.
bool acts_through_positions(const Finding& f);

/// Joints with a finding without a name whose signals are positions.
std::set<int> joints_in_question(const Diagnosis& d);

/// Errors of held-out parts of the training recordings with the curves that have no name, relative, (n).
/// @param joint  the only one whose curves count; nothing: those of all.
VectorXd errors_with_curves(const DiagnosisState& x, std::optional<JointIndex> joint = {});

/// Asks about errors of a torque channel that come from another joint, where a joint has a finding without a name that
/// depends on the torque of another one, or a cable from it: named, they take its place where they say as much.
void ask_about_crosstalk(DiagnosisState& x);

/// Asks about causes that nobody asked about before, on joints in question or beside names that may stand for another,
/// and puts the best, with what is found beside it, in place of what was found where that says as much.
/// @param hidden  joints in question where all names are taken away.
void ask_later_causes(DiagnosisState& x, const std::set<int>& hidden);

}  // namespace veridyn
