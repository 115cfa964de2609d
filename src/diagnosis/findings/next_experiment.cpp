#include "diagnosis/findings/next_experiment.hpp"

#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/channel_effect.hpp"

namespace veridyn {
namespace {

constexpr int kSlowPasses = 2;

// True for effects that a motion designed by `excite` can distinguish, see ExcitationOptions::between.
bool is_designable(const std::string& effect) {
  if (effect == AddedLoad::kName) return true;
  if (!has_effect(effect)) return false;
  const ChannelEffect* channel = channel_effect(effect);
  if (channel != nullptr) return channel->has_rigid_columns();
  return !find_effect(effect).traits().uses_source;
}

// True for effects that act at low speed and after reversals.
bool is_slow(const std::string& effect) {
  return has_effect(effect) && find_effect(effect).traits().slow;
}

}  // namespace

NextExperiment next_experiment(const Diagnosis& d) {
  for (const Finding& f : d.findings) {
    for (const Rival& r : f.rivals) {
      const std::string first = effect_of(f.cause);
      const std::string second = effect_of(r.cause);
      if (!is_designable(first) || !is_designable(second) || first == second) continue;
      NextExperiment out;
      out.between = {f.cause, r.cause};
      if (is_slow(first) || is_slow(second)) out.slow_passes = kSlowPasses;
      return out;
    }
  }
  NextExperiment out;
  for (const Finding& f : d.findings) {
    if (!f.shape) continue;
    std::string signals;
    bool slow = false;
    for (const std::string& s : f.shape->signals) {
      signals += (signals.empty() ? "" : " and ") + s;
      // Signals that begin with q are positions, those with h displacements since a reversal.
      slow = slow || s.front() == 'q' || s.front() == 'h';
    }
    out.shows = "what joint " + std::to_string(f.joint->value + 1) + " depends on over " + signals;
    if (slow) out.slow_passes = kSlowPasses;
    break;
  }
  return out;
}

}  // namespace veridyn
