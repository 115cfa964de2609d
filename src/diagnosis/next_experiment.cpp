#include "next_experiment.hpp"

#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/channel_effect.hpp"

namespace veridyn {
namespace {

constexpr int kSlowPasses = 2;

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
      const std::string first = effect_of(f.cause);
      const std::string second = effect_of(r.cause);
      if (!can_be_asked(first) || !can_be_asked(second) || first == second) continue;
      NextExperiment out;
      out.between = {f.cause, r.cause};
      if (is_slow(first) || is_slow(second)) out.slow_passes = kSlowPasses;
      return out;
    }
  }
  return {};
}

}  // namespace veridyn
