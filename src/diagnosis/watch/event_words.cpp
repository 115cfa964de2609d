#include "diagnosis/watch/event_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/effect.hpp"

namespace veridyn::watching {
namespace {

std::string place_words(const WatchEvent& e) {
  const std::string place = split_cause(e.text).place;
  if (const auto joint = joint_of(e.cause)) return fmt::format("joint {} ({})", joint->value + 1, place);
  return std::holds_alternative<AddedLoad>(e.cause) ? "link " + place : "all joints";
}

std::string rivals_words(const WatchEvent& e) {
  std::string out;
  for (const WatchRival& r : e.rivals) out += (out.empty() ? "" : ", ") + r.text;
  return out.empty() ? "" : " As likely within odds of 100 to 1: " + out + ".";
}

std::string change_words(const WatchEvent& e) {
  const std::string size =
      fmt::format("{:+.3g} {} (95 %: {:.3g} to {:.3g})", e.value, e.unit, e.low, e.high);
  if (std::holds_alternative<AddedLoad>(e.cause))
    return fmt::format("{} carries {} more at its frame's origin than the model has", place_words(e), size);
  if (std::holds_alternative<ExternalContact>(e.cause))
    return fmt::format(e.stage == WatchStage::kOver ? "something pushes the arm on {} or beyond: mean torque {}"
                                                    : "something acts that no single cause explains, a push on {} or beyond, or a change that is not on the list: mean torque {}",
                       place_words(e), size);
  std::string effect = effect_of(e.cause);
  std::replace(effect.begin(), effect.end(), '_', ' ');
  for (const char* name : {"coulomb", "stribeck"}) {
    if (effect.rfind(name, 0) == 0) effect[0] = static_cast<char>(std::toupper(effect[0]));
  }
  return fmt::format("{} of {} differs by {}", effect, place_words(e), size);
}

}  // namespace

std::string sentence(const WatchEvent& e) {
  const auto since = [&] { return fmt::format("since {:.2f} s {}.", e.since, change_words(e)); };
  switch (e.stage) {
    case WatchStage::kSuspected:
      return fmt::format("{:.2f} s: something changed, at about {:.2f} s; most like {}.", e.time, e.since, e.text);
    case WatchStage::kNamed:
    case WatchStage::kUnnamed: return fmt::format("{:.2f} s: {}{}", e.time, since(), rivals_words(e));
    case WatchStage::kRefined: return fmt::format("{:.2f} s: {}", e.time, since());
    case WatchStage::kWithdrawn: return fmt::format("{:.2f} s: withdrawn: {}", e.time, since());
    case WatchStage::kOver:
      return fmt::format("{:.2f} s: over again; from {:.2f} to {:.2f} s {}.", e.time, e.since, e.until, change_words(e));
    case WatchStage::kPresent:
      return fmt::format("{:.2f} s: from the beginning on, {}.{}", e.time, change_words(e), rivals_words(e));
    case WatchStage::kBlind: break;
  }
  return {};
}

std::string blind_sentence(const WatchEvent& e, const std::string& why) {
  return fmt::format("{:.2f} s: nothing can be watched since {:.2f} s: {}.{}", e.time, e.since, why,
                     e.id > 0 ? " What was suspected since is withdrawn." : "");
}

}  // namespace veridyn::watching
