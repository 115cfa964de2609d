#include "report/json/json_value.hpp"
#include "veridyn/report/diagnosis_json.hpp"

namespace veridyn {
namespace {

Json verdict_of(const FrictionVerdict& v, const std::string& sentence) {
  Json out = {{"effect", v.effect}, {"state", name_of(v.state)}, {"sentence", sentence}};
  out["p_value"] = v.p_value ? Json(*v.p_value) : Json();
  out["parameters"] = Json::object();
  for (const FoundParameter& p : v.parameters)
    out["parameters"][p.name] = {{"value", p.value}, {"unit", p.unit}, {"ci95", Json::array({p.low, p.high})}};
  return out;
}

Json joint_study_json(const JointFrictionStudy& j) {
  const FrictionCurve& c = j.curve;
  Json out = {{"joint", j.joint.value + 1}, {"coordinate", j.coordinate}, {"unit", j.effort}, {"velocity_unit", j.unit + "/s"}};
  Json interval = Json::array();
  for (Eigen::Index k = 0; k < c.velocity.size(); ++k)
    interval.push_back({c.torque[k] - c.half_width[k], c.torque[k] + c.half_width[k]});
  out["curve"] = {{"velocity", json_list(c.velocity)}, {"torque", json_list(c.torque)}, {"interval", std::move(interval)}};
  out["speeds"] = Json::array();
  for (const FrictionAtSpeed& s : j.speeds)
    out["speeds"].push_back({{"velocity", s.velocity}, {"torque", s.torque}, {"deviation", s.deviation},
                             {"seconds", s.seconds}, {"runs", s.runs}});
  out["breakaways"] = Json::array();
  for (const FrictionBreakaway& b : j.breakaways)
    out["breakaways"].push_back({{"recording", b.source}, {"time", b.time}, {"direction", b.direction}, {"torque", b.torque}});
  out["verdicts"] = json_each(j.verdicts, [&](const FrictionVerdict& v) -> Json { return verdict_of(v, v.effect + " " + name_of(v.state) + ": " + v.words); });
  out["held_out"] = {{"plain", j.error_plain}, {"confirmed", j.error}};
  return out;
}

}  // namespace

std::string to_json(const FrictionStudy& study) {
  Json out = json_head("friction");
  out["robot"] = study.robot;
  out["resting"] = study.resting;
  out["held_out"] = study.held_out;
  out["joints"] = json_each(study.joints, joint_study_json);
  out["reason"] = study.reason;
  return json_text(out);
}

}  // namespace veridyn
