#include "veridyn/report/setting_names.hpp"

namespace veridyn {

const char* name_of(Method method) {
  switch (method) {
    case Method::kOls:
      return "ols";
    case Method::kWls:
      return "wls";
    case Method::kFeasible:
      return "feasible";
    case Method::kIv:
      return "iv";
    case Method::kDidim:
      return "didim";
  }
  return "";
}

const char* name_of(JointWeights weights) {
  return weights == JointWeights::kRange ? "range" : "residual";
}

const char* name_of(PhysicalCondition condition) {
  switch (condition) {
    case PhysicalCondition::kPseudoInertia:
      return "pseudo-inertia";
    case PhysicalCondition::kPrincipalMoments:
      return "principal-moments";
    case PhysicalCondition::kNone:
      return "none";
  }
  return "";
}

const char* name_of(EffectSigns signs) {
  return signs == EffectSigns::kPhysical ? "physical" : "any";
}

const char* name_of(Filtering filtering) {
  return filtering == Filtering::kMatched ? "matched" : "signals";
}

const char* name_of(VelocitySource velocity) {
  return velocity == VelocitySource::kRecorded ? "recorded" : "derived";
}

const char* name_of(StaleRows stale_rows) {
  return stale_rows == StaleRows::kFilled ? "filled" : "kept";
}

const char* name_of(IdentificationStatus status) {
  switch (status) {
    case IdentificationStatus::kDone:
      return "done";
    case IdentificationStatus::kRankDeficient:
      return "rank-deficient";
    case IdentificationStatus::kNoData:
      return "no-data";
    case IdentificationStatus::kNotConverged:
      return "not-converged";
    case IdentificationStatus::kNoDriveGains:
      return "no-drive-gains";
  }
  return "";
}

const char* name_of(Identifiability class_of_one) {
  switch (class_of_one) {
    case Identifiability::kAlone:
      return "alone";
    case Identifiability::kInCombination:
      return "in-combination";
    case Identifiability::kNot:
      return "not";
  }
  return "";
}

}  // namespace veridyn
