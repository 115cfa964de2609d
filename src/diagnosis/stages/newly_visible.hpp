#pragma once

#include <string>
#include <vector>

#include "diagnosis/stages/channel_correction.hpp"
#include "diagnosis/stages/diagnosis_state.hpp"

namespace veridyn {

/// Parameters of bodies that an arm shows with the gravity it has and did not show with another:
/// upright, a base that turns about the vertical shows no first moment of what it carries. A model
/// from before has anything there, and its error would look like a load on the first links.
///
/// With phi = N z the standard parameters that the torques under `gravity` do not show, beta = K phi the
/// base parameters now: those of beta whose row of K N is not zero, by their independent parameters.
///
/// @param tilted   the arm, with values.
/// @param gravity  the direction that its values were identified with.
/// @return         names of standard parameters (m_LINK, hx_LINK, ..).
std::vector<std::string> newly_visible(const Model& tilted, const Eigen::Vector3d& gravity);

/// Estimates the correction of gravity together with the newly visible parameters, for an arm whose
/// values are facts, because one without the other is biased. All other values are kept.
///
/// @param h        the hypothesis that was corrected.
/// @param channel  its correction alone; unchanged where nothing is newly visible.
void estimate_newly_visible(const DiagnosisState& x, const Hypothesis& h, CorrectedChannel& channel);

}  // namespace veridyn
