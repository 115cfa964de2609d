#include "next_experiment.hpp"

#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/channel_effect.hpp"

namespace veridyn {
namespace {

std::string cause_text(const std::string& effect, int joint, const std::string& frame) {
  if (!frame.empty() && effect == AddedLoad::kName) return effect + " on " + frame;
  return joint > 0 ? effect + " on joint " + std::to_string(joint) : effect;
}

// "payload:flange", "torque_gain:2"; as `excite --between` takes them.
std::string asked_text(const std::string& effect, int joint, const std::string& frame) {
  if (!frame.empty() && effect == AddedLoad::kName) return effect + ":" + frame;
  return effect + ":" + (joint > 0 ? std::to_string(joint) : "arm");
}

// What `excite` can tell apart from others by the motion of joints: its own words are in
// ExcitationOptions::between.
bool can_be_asked(const std::string& effect) {
  if (effect == AddedLoad::kName) return true;
  if (!has_effect(effect)) return false;
  const ChannelEffect* channel = channel_effect(effect);
  if (channel != nullptr) return channel->has_rigid_columns();
  return !find_effect(effect).traits().uses_source;
}

// Shows itself at low speed and after reversals.
bool is_slow(const std::string& effect) {
  return has_effect(effect) && find_effect(effect).traits().slow;
}

}  // namespace

NextExperiment next_experiment(const Diagnosis& d) {
  for (const Finding& f : d.findings) {
    for (const Rival& r : f.rivals) {
      const bool can_be_planned =
          can_be_asked(f.effect) && can_be_asked(r.effect) && f.effect != r.effect;
      if (!can_be_planned) continue;
      return {{cause_text(f.effect, f.joint, f.frame), cause_text(r.effect, r.joint, r.frame)},
              "veridyn excite " + d.baseline.robot +
                  " -o next.csv --criterion discriminate --between " +
                  asked_text(f.effect, f.joint, f.frame) + "," +
                  asked_text(r.effect, r.joint, r.frame) +
                  (is_slow(f.effect) || is_slow(r.effect) ? " --slow-passes 2" : "")};
    }
  }
  return {};
}

}  // namespace veridyn
