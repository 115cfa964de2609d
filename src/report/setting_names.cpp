#include "veridyn/report/setting_names.hpp"

namespace veridyn {

const char* name_of(Method method) {
  static constexpr const char* kNames[] = {"ols", "wls", "feasible", "iv", "didim"};
  return kNames[static_cast<int>(method)];
}

const char* name_of(JointWeights weights) {
  return weights == JointWeights::kRange ? "range" : "residual";
}

const char* name_of(PhysicalCondition condition) {
  static constexpr const char* kNames[] = {"pseudo-inertia", "principal-moments", "none"};
  return kNames[static_cast<int>(condition)];
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
  static constexpr const char* kNames[] = {"done", "rank-deficient", "no-data", "not-converged", "no-drive-gains"};
  return kNames[static_cast<int>(status)];
}

const char* name_of(Identifiability class_of_one) {
  static constexpr const char* kNames[] = {"alone", "in-combination", "not"};
  return kNames[static_cast<int>(class_of_one)];
}

}  // namespace veridyn
