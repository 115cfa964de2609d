#include "veridyn/report/comparison_json.hpp"

#include "report/json/json_value.hpp"

namespace veridyn {
namespace {

const char* name_of(ComparisonVerdict verdict) {
  return verdict == ComparisonVerdict::kSame     ? "same"
         : verdict == ComparisonVerdict::kDiffer ? "differ"
                                                 : "cannot-tell";
}

Json model_json(const ComparedModel& m) {
  return {{"robot", m.name},
          {"recordings", m.recordings},
          {"clusters", m.clusters},
          {"training_error", json_list(m.training_error)},
          {"note", m.note.empty() ? Json() : Json(m.note)}};
}

Json difference_json(const ModelDifference& d) {
  return {{"quantity", name_of(d.quantity)},
          {"name", d.name.empty() ? Json() : Json(d.name)},
          {"expression", d.expression.empty() ? Json() : Json(d.expression)},
          {"unit", d.unit},
          {"effect", d.effect.empty() ? Json() : Json(d.effect)},
          {"same_as", d.same_as.empty() ? Json() : Json(d.same_as)},
          {"joint", d.joint.value + 1},
          {"coordinate", d.coordinate},
          {"before", d.before},
          {"after", d.after},
          {"difference", d.difference},
          {"std", d.deviation},
          {"ci95", {d.low, d.high}},
          {"t", d.t},
          {"degrees_of_freedom", d.degrees_of_freedom},
          {"p_value", d.p_value},
          {"p_corrected", d.p_corrected},
          {"significant", d.significant},
          {"torque", d.torque.size() > 0 ? json_list(d.torque) : Json()},
          {"sentence", d.sentence}};
}

Json torque_json(const std::vector<TorqueDifference>& joints) {
  Json out = Json::array();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const TorqueDifference& j = joints[i];
    out.push_back({{"joint", i + 1},
                   {"coordinate", j.coordinate},
                   {"unit", j.unit},
                   {"before", j.before},
                   {"after", j.after},
                   {"difference", j.difference},
                   {"share", j.share},
                   {"by_chance", j.by_chance},
                   {"bodies", j.bodies},
                   {"effects", j.effects}});
  }
  return out;
}

}  // namespace

std::string to_json(const ModelComparison& c) {
  Json out = json_head("compare");
  out["robot"] = c.robot;
  out["verdict"] = name_of(c.verdict);
  out["significance"] = c.significance;
  out["correction"] = "holm";
  out["before"] = model_json(c.before);
  out["after"] = model_json(c.after);
  out["same_motion"] = c.same_motion;
  out["structure"] = json_each(c.structure, [&](const StructureDifference& s) -> Json { return {{"kind", name_of(s.kind)}, {"sentence", s.sentence}}; });
  out["compared"] = c.compared();
  out["differences"] = c.significant();
  for (const auto& [key, list] :
       {std::pair("joints", &c.joints), std::pair("parameters", &c.parameters)}) {
    out[key] = json_each(*list, difference_json);
  }
  out["only_before"] = c.only_before;
  out["only_after"] = c.only_after;
  out["torque"] = torque_json(c.torque);
  return json_text(out);
}

}  // namespace veridyn
