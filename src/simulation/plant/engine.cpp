#include "veridyn/simulation/engine.hpp"

#include <utility>

#ifdef VERIDYN_WITH_MUJOCO
#include "simulation/plant/mujoco_engine.hpp"
#endif
#include "simulation/plant/passive_engine.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"
#include "veridyn/simulation/plant.hpp"

namespace veridyn {

const char* describe(StepStatus status) {
  switch (status) {
    case StepStatus::kOk:
      return "moves";
    case StepStatus::kNotFinite:
      return "has a torque, position or velocity that is not finite";
    case StepStatus::kNotPositive:
      return "stands where the mass matrix has no inverse";
    case StepStatus::kTooStiff:
      return "moves faster than the smallest substep can follow";
    case StepStatus::kRanAway:
      return "is more than ten times its range off its set point";
  }
  return "";
}

std::vector<std::string> engine_names() {
#ifdef VERIDYN_WITH_MUJOCO
  return {"veridyn", "mujoco"};
#else
  return {"veridyn"};
#endif
}

std::unique_ptr<Engine> make_engine(const std::string& name, const Model& arm) {
  if (!arm.arm_effects().empty()) {
    const Model whole = with_arm_states(arm);
    if (whole.joints() != arm.joints())
      return make_passive_engine(make_engine(name, whole), whole, arm.joints());
  }
  if (name == "veridyn") return std::make_unique<Plant>(arm);
#ifdef VERIDYN_WITH_MUJOCO
  if (name == "mujoco") return make_mujoco_engine(arm);
#endif
  require(name != "mujoco", "engine mujoco: this veridyn was built without it (libmujoco-dev).");
  throw InvalidInput(text("found the engine '", name, "'", did_you_mean(name, engine_names()),
                          ", expected one of: ", listed(engine_names()), "."));
}

}  // namespace veridyn
