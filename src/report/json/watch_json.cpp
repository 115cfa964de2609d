#include "veridyn/report/watch_json.hpp"

#include <set>

#include "report/json/json_value.hpp"

namespace veridyn {
namespace {

Json event_json(const WatchEvent& e) {
  if (e.stage == WatchStage::kBlind)
    return {{"event", name_of(e.stage)}, {"id", e.id}, {"time", e.time}, {"since", e.since}, {"sentence", e.sentence}};
  Json rivals = json_each(e.rivals, [&](const WatchRival& r) -> Json { return {{"cause", r.text}, {"lacks", r.evidence}}; });
  const std::optional<JointIndex> joint = joint_of(e.cause);
  Json out = {{"event", name_of(e.stage)},
              {"id", e.id},
              {"time", e.time},
              {"since", e.since},
              {"cause", e.text},
              {"effect", effect_of(e.cause)},
              {"joint", joint ? joint->value + 1 : 0},
              {"place", split_cause(e.text).place},
              {"value", e.value},
              {"ci95", {e.low, e.high}},
              {"unit", e.unit},
              {"strength", e.strength}};
  if (e.stage == WatchStage::kOver) out["until"] = e.until;
  out["rivals"] = rivals;
  out["sentence"] = e.sentence;
  return out;
}

}  // namespace

int WatchedSource::alarms() const {
  std::set<int> ids;
  for (const WatchEvent& e : events) {
    if (e.stage != WatchStage::kPresent && e.stage != WatchStage::kBlind) ids.insert(e.id);
  }
  for (const WatchEvent& e : events) {
    if (e.stage == WatchStage::kBlind) ids.erase(e.id);  // the unusable rows explain the suspicion
  }
  return static_cast<int>(ids.size());
}

std::string json_line(const WatchEvent& event, const std::string& source) {
  Json out = event_json(event);
  out["source"] = source;
  return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string to_json(const std::vector<WatchedSource>& sources, const Model& arm, bool running) {
  Json out = json_head("watch");
  out["robot"] = arm.name();
  out["running"] = running;
  out["sources"] = Json::array();
  for (const WatchedSource& s : sources) {
    Json events = Json::array();
    for (const WatchEvent& e : s.events) events.push_back(event_json(e));
    const double watched = s.to - s.from - s.learned - s.blind;
    out["sources"].push_back({{"source", s.source},
                              {"seconds", s.to - s.from},
                              {"learned", s.learned},
                              {"blind", s.blind},
                              {"alarms", s.alarms()},
                              {"alarms_per_hour", watched > 0.0 ? 3600.0 * s.alarms() / watched : 0.0},
                              {"events", events}});
  }
  return json_text(out);
}

}  // namespace veridyn
