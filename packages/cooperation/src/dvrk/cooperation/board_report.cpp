#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "veridyn/model/suggestion.hpp"
#include "dvrk/cooperation/board_cooperation.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {

EmulatedFault parse_emulated_fault(const std::string& words, const Scenario& scenario) {
  using Kind = EmulatedFault::Kind;
  static const std::vector<std::pair<std::string, Kind>> kinds = {
      {"silent", Kind::kSilent},   {"amplifier", Kind::kAmplifier}, {"power", Kind::kPower},
      {"encoder", Kind::kEncoder}, {"jump", Kind::kJump},           {"limp", Kind::kLimp},
      {"weak", Kind::kWeak},       {"reversed", Kind::kReversed},   {"stuck", Kind::kStuck}};
  const auto colon = words.find(':');
  const auto at = words.rfind('@');
  std::vector<std::string> names;
  for (const auto& [name, kind] : kinds) names.push_back(name);
  require(colon != std::string::npos && at != std::string::npos && colon < at, "found '", words,
          "', expected KIND:ARM@SECONDS with a kind of ", listed(names), ".");
  const std::string what = words.substr(0, colon);
  const auto kind = std::find_if(kinds.begin(), kinds.end(),
                                 [&](const auto& one) { return one.first == what; });
  require(kind != kinds.end(), "found the fault '", what, "'", did_you_mean(what, names),
          ", expected one of: ", listed(names), ".");
  const std::string name = words.substr(colon + 1, at - colon - 1);
  const auto arm = std::find_if(scenario.arms.begin(), scenario.arms.end(),
                                [&](const ScenarioArm& a) { return a.name == name; });
  require(arm != scenario.arms.end(), "found no arm '", name, "' in the scenario.");
  const char* seconds = words.c_str() + at + 1;
  char* end = nullptr;
  EmulatedFault fault;
  fault.kind = kind->second;
  fault.arm = static_cast<int>(arm - scenario.arms.begin());
  fault.at = std::strtod(seconds, &end);
  require(end != seconds && *end == '\0' && fault.at > 0.0 && fault.at < 1e9, "found '", seconds,
          "' in '", words, "', expected seconds above zero.");
  return fault;
}

std::string faults_text(const std::vector<ArmAfterFault>& arms,
                              const std::vector<LaterFault>& later) {
  std::string out;
  for (const LaterFault& one : later) out += fmt::format("At {:.4g} s also: {}.\n", one.at, one.what);
  for (const ArmAfterFault& arm : arms) {
    out += fmt::format("Arm {} {}; its tip moved {:.3g} mm{}.\n", arm.name,
                       arm.off_at       ? fmt::format("lost its power at {:.4g} s", *arm.off_at)
                       : arm.rest_after ? fmt::format("was at rest after {:.3g} s", *arm.rest_after)
                                        : "did NOT come to rest",
                       1e3 * arm.moved,
                       arm.known ? "" : " as far as is known, its boards did not answer to the end");
  }
  return out;
}

std::string power_text(OffState power, const std::string& not_off) {
  if (power == OffState::kConfirmed || power == OffState::kNotAsked) return describe(power);
  return fmt::format("power off is NOT CONFIRMED ({}: {}): press the emergency stop", not_off,
                     describe(power));
}

std::string BoardCooperationRun::report() const {
  std::string out = run.report();
  if (live)
    out = fmt::format("{}: {:.4g} s by commands from a line, {} of them, {} refused.\n"
                      "Largest force: {:.3g} N.\n",
                      run.name, off_at, commands, refused, largest_force);
  out += stepped ? fmt::format("{} cycles, {} late by the boards' clock, which stands still while the program computes.\n",
                               cycles, late)
                 : fmt::format("{} cycles, {} late; a cycle took {:.0f} us, at most {:.0f} us.\n", cycles,
                               late, 1e6 * mean_cycle, 1e6 * longest_cycle);
  const bool all = std::all_of(after_fault.begin(), after_fault.end(),
                               [](const ArmAfterFault& arm) { return arm.held(); });
  if (end != BoardEnd::kDone && release_at > 0.0 && fault_at > release_at)
    out += fmt::format("From {:.4g} s the pretension was given up from {:.3g} N; at {:.4g} s {}, at most "
                       "{:.3g} N, and at {:.4g} s power went with {:.3g} N left.\n",
                       release_at, force_at_release, fault_at, why, largest_force_after_fault, off_at,
                       force_at_off);
  else if (end != BoardEnd::kDone && release_at > 0.0)
    out += fmt::format("At {:.4g} s {}: {}, at most {:.3g} N; from {:.4g} s the pretension "
                       "was given up from {:.3g} N, and at {:.4g} s power went with {:.3g} N left.\n",
                       fault_at, why, all ? "all arms held" : "NOT all arms were held",
                       largest_force_after_fault, release_at, force_at_release, off_at, force_at_off);
  else if (end != BoardEnd::kDone)
    out += fmt::format("The run did not begin: {}.\n", why);
  out += faults_text(after_fault, later);
  out += fmt::format("Boards at the end: {}.\n", power_text(power, not_off));
  return out;
}

}  // namespace veridyn::dvrk
