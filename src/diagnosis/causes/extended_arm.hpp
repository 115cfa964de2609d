#pragma once

#include <vector>

#include "diagnosis/evidence/hypotheses.hpp"

namespace veridyn {

/// An accepted hypothesis with what was fitted.
struct FoundCause {
  Hypothesis hypothesis;
  EffectTerm term;             ///< with its constants; of no payload
  std::vector<double> values;  ///< Values of its parameters
  InertialParameters load;     ///< Parameters of a payload, in the frame that carries it
};

/// The arm with all that was found. Errors of channels and the tilt are corrected, payloads become
/// frames with bodies. Where the arm's values are facts (`changes`), found values are written too,
/// and changed effects get their new ones; otherwise new effects wait for an identification.
Model extended_arm(const Model& arm, const std::vector<FoundCause>& found, bool changes);

}  // namespace veridyn
