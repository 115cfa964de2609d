#pragma once

#include "veridyn/identification/identification.hpp"

namespace veridyn {

// Names of settings, the same on the command line and in JSON.

const char* name_of(Method method);                ///< ols, wls, feasible
const char* name_of(JointWeights weights);         ///< range, residual
const char* name_of(PhysicalCondition condition);  ///< pseudo-inertia, principal-moments, none
const char* name_of(EffectSigns signs);            ///< physical, any
const char* name_of(Filtering filtering);          ///< matched, signals
const char* name_of(VelocitySource velocity);      ///< recorded, derived
const char* name_of(StaleRows stale_rows);         ///< filled, kept
/// done, rank-deficient, no-data, not-converged, no-drive-gains
const char* name_of(IdentificationStatus status);
const char* name_of(Identifiability class_of_one);  ///< alone, in-combination, not

}  // namespace veridyn
