#include "cli/cooperation/teleoperation_json.hpp"

#include "report/json/json_value.hpp"

namespace veridyn::cli {

std::string teleoperation_json(const dvrk::TeleoperationRun& run) {
  Json out = json_head("cooperate");
  out["kind"] = "teleoperation";
  out["scenario"] = run.name;
  out["status"] = run.met() ? "done" : "stopped";
  out["reason"] = run.why;
  out["latency"] = run.latency ? Json(*run.latency) : Json();
  out["largest_force"] = run.largest_force;
  out["cycles"] = run.cycles;
  out["late"] = run.late;
  out["power"] = describe(run.power);
  out["phases"] = Json::array();
  for (std::size_t p = 0; p < run.phases.size(); ++p)
    out["phases"].push_back({{"phase", run.phases[p]},
                             {"tracking_rms", run.tracking_rms[p]},
                             {"tracking_largest", run.tracking_largest[p]},
                             {"follower_moved", run.follower_moved[p]},
                             {"force", run.force_follower[p]},
                             {"hand_force", run.force_hand[p]}});
  return written(out);
}

}  // namespace veridyn::cli
