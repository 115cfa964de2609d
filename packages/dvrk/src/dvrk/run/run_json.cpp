#include "dvrk/run/run_json.hpp"

#include <nlohmann/json.hpp>

namespace veridyn::dvrk {
namespace {

using Json = nlohmann::ordered_json;

// The keys that every command has: version, command, arm.
Json head(const std::string& command, const std::string& arm) {
  return {{"veridyn", VERIDYN_VERSION}, {"command", "dvrk " + command}, {"arm", arm}};
}

Json json_of(const FaultLog& faults) {
  Json list = Json::array();
  for (int k = 1; k <= kConditions; ++k) {
    const auto condition = static_cast<Condition>(k);
    const FaultEntry& entry = faults[condition];
    if (entry.count == 0) continue;
    list.push_back({{"condition", number_in_section_17(condition)},
                    {"name", describe(condition)},
                    {"count", entry.count},
                    {"board", entry.board.value_or(-1)},
                    {"channel", entry.channel ? *entry.channel + 1 : 0},
                    {"found", entry.value},
                    {"found_text", describe_found(condition, entry.value)}});
  }
  return list;
}

}  // namespace

std::string to_json(const RunResult& run, const FaultLog& faults, const std::string& command,
                    const std::string& arm) {
  Json out = head(command, arm);
  out["rows"] = run.rows.rows();
  out["complete"] = run.complete;
  out["why"] = run.why;
  const WriteGap& gap = run.timing.longest_gap;
  out["power_off"] = run.power == OffState::kNotAsked    ? "not asked"
                     : run.power == OffState::kConfirmed ? "confirmed"
                                                         : "not confirmed";
  out["boards_say"] = describe(run.power);
  out["rows_kept"] = run.kept;
  out["loop"] = {{"cycles", run.timing.cycles},
                 {"late", run.timing.late},
                 {"late_own", run.timing.late_own},
                 {"late_replies", run.timing.late_replies},
                 {"late_system", run.timing.late - run.timing.late_own - run.timing.late_replies},
                 {"rate", run.timing.rate},
                 {"rate_reached", run.timing.measured_rate()},
                 {"mean", run.timing.mean},
                 {"longest", run.timing.longest},
                 {"longest_gap",
                  {{"seconds", gap.seconds},
                   {"at", gap.at},
                   {"reason", describe_reason(gap)},
                   {"slept", gap.slept},
                   {"woken_late", gap.woken_late},
                   {"replies", gap.replies},
                   {"own", gap.own},
                   {"interrupted", gap.interrupted}}}};
  out["faults"] = json_of(faults);
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string to_json(const std::vector<std::pair<std::string, std::int64_t>>& counts,
                    const std::string& command, const std::string& arm) {
  Json out = head(command, arm);
  for (const auto& [name, count] : counts) out[name] = count;
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace veridyn::dvrk
