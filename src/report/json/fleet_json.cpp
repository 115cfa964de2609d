#include "report/json/settings_json.hpp"
#include "veridyn/report/json.hpp"

namespace veridyn {

std::string to_json(const Fleet& fleet) {
  Json out = json_head("fleet");
  out["robot"] = fleet.robot;
  out["status"] = fleet.model ? "done" : "undetermined";
  out["reason"] = fleet.reason;
  out["arms"] = fleet.members.size();
  out["rows"] = fleet.rows;
  out["outliers"] = json_each(fleet.outliers, [&](const FleetOutlier& o) -> Json {
    return {{"arm", o.arm}, {"what", o.what}, {"joint", o.joint ? o.joint->value + 1 : 0}, {"value", o.value},
            {"median", o.median}, {"deviations", o.deviations}};
  });
  out["base_parameters"] = base_json(fleet.base);
  out["spreads"] = json_each(fleet.spreads, [&](const FleetSpread& s) -> Json {
    return {{"name", s.name}, {"unit", s.unit}, {"median", s.median}, {"spread", s.spread}, {"arms", s.arms}};
  });
  out["members"] = Json::array();
  for (const FleetMember& m : fleet.members) {
    Json own = Json::object();
    for (std::size_t k = 0; k < fleet.spreads.size(); ++k)
      own[fleet.spreads[k].name] = m.own[static_cast<Eigen::Index>(k)];
    out["members"].push_back({{"arm", m.name},
                              {"recordings", m.recordings},
                              {"rows", m.rows},
                              {"relative_error", json_list(m.relative_error)},
                              {"alone", {{"relative_error", json_list(m.alone_error)}}},
                              {"own", std::move(own)}});
  }
  out["other_bodies"] = json_each(fleet.other_bodies, [&](const FleetLeftOut& o) -> Json {
    return {{"arm", o.arm}, {"joint", o.joint.value + 1}, {"relative_error", o.with_fleet},
            {"alone", {{"relative_error", o.with_own}}}, {"excess", o.excess}, {"median_excess", o.median_excess},
            {"deviations", o.deviations}};
  });
  out["undetermined"] = json_each(fleet.undetermined, [&](const UndeterminedArm& u) -> Json { return {{"arm", u.arm}, {"why", u.why}}; });
  out["left_out_recordings"] = unused_json(fleet.unusable_recordings);
  out["remarks"] = fleet.remarks;
  return json_text(out);
}

}  // namespace veridyn
