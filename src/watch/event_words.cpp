#include "watch/event_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/effect.hpp"

namespace veridyn::watching {
namespace {

std::string place_words(const WatchEvent& e) {
  return e.joint > 0 ? fmt::format("joint {} ({})", e.joint, e.place)
                     : e.effect == AddedLoad::kName ? "link " + e.place : "all joints";
}

std::string rivals_words(const WatchEvent& e) {
  std::string out;
  for (const WatchRival& r : e.rivals) out += (out.empty() ? "" : ", ") + r.cause;
  return out.empty() ? "" : " As likely within odds of 100 to 1: " + out + ".";
}

std::string what(const WatchEvent& e) {
  const std::string size =
      fmt::format("{:+.3g} {} (95 %: {:.3g} to {:.3g})", e.value, e.unit, e.low, e.high);
  if (e.effect == AddedLoad::kName)
    return fmt::format("{} carries {} more at its frame's origin than the model has", place_words(e), size);
  if (e.effect == ExternalContact::kName)
    return fmt::format("something pushes the arm on {} or beyond: mean torque {}", place_words(e), size);
  std::string effect = e.effect;
  std::replace(effect.begin(), effect.end(), '_', ' ');
  for (const char* name : {"coulomb", "stribeck"}) {
    if (effect.rfind(name, 0) == 0) effect[0] = static_cast<char>(std::toupper(effect[0]));
  }
  return fmt::format("{} of {} differs by {}", effect, place_words(e), size);
}

}  // namespace

std::string sentence(const WatchEvent& e) {
  switch (e.stage) {
    case WatchStage::kSuspected:
      return fmt::format("{:.2f} s: something changed, at about {:.2f} s; most like {}.", e.time,
                         e.since, e.cause);
    case WatchStage::kNamed:
      return fmt::format("{:.2f} s: since {:.2f} s {}.{}", e.time, e.since, what(e),
                         rivals_words(e));
    case WatchStage::kRefined:
      return fmt::format("{:.2f} s: since {:.2f} s {}.", e.time, e.since, what(e));
    case WatchStage::kOver:
      return fmt::format("{:.2f} s: over again; from {:.2f} to {:.2f} s {}.", e.time, e.since,
                         e.until, what(e));
  }
  return {};
}

}  // namespace veridyn::watching
