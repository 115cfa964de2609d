#include "report/json/json_value.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/files/physical_faults.hpp"
#include "veridyn/report/json.hpp"
#include "veridyn/report/setting_names.hpp"

namespace veridyn {
namespace {

Json coordinates_json(const Model& arm) {
  return json_each(arm.coordinates(), [&](const Coordinate& c) -> Json {
    return {{"name", c.name}, {"unit", position_unit(c)}, {"effort_unit", effort_unit(c)},
            {"position", {c.limits.lower, c.limits.upper}}, {"velocity", c.limits.velocity},
            {"acceleration", c.limits.acceleration}, {"effort", c.limits.effort},
            {"drive_gain", c.drive_gain == 0.0 ? Json() : Json(c.drive_gain)}};
  });
}

const char* type_name(JointType type) {
  return type == JointType::kFixed      ? "fixed"
         : type == JointType::kRevolute ? "revolute"
                                        : "prismatic";
}

// A linear form as {coordinate: coefficient}: {"pitch_motor": -0.8306, "yaw1_motor": 1.2178}.
Json form_json(const Model& arm, const Axis& axis) {
  Json out = Json::object();
  for (int i = 0; i < arm.joints() && i < axis.coefficients.size(); ++i) {
    if (axis.coefficients[i] != 0.0) out[arm.coordinates()[i].name] = axis.coefficients[i];
  }
  return out;
}

Json frames_json(const Model& arm) {
  return json_each(arm.frames(), [&](const Frame& frame) -> Json {
    return {{"name", frame.name}, {"parent", frame.parent ? arm.frames()[frame.parent->value].name : "world"},
            {"type", type_name(frame.type)}, {"variable", form_json(arm, frame.variable)}, {"offset", frame.variable.offset},
            {"body", frame.body.has_value()}};
  });
}

Json effects_json(const Model& arm) {
  return json_each(arm.effects(), [&](const EffectTerm& term) -> Json {
    return {{"effect", term.effect}, {"axis", form_json(arm, term.axis)},
            {"frame", term.frame.empty() ? Json() : Json(term.frame)}, {"values", term.values}};
  });
}

Json base_json(const RobotInfo& info) {
  Json out = Json::array();
  for (int j = 0; j < info.base.size(); ++j) {
    const auto at = static_cast<std::size_t>(j);
    const auto own = static_cast<std::size_t>(info.base.independent[at]);
    Json coefficients = Json::object();
    for (std::size_t p = 0; p < info.parameters.size(); ++p) {
      const double k = info.base.K(j, static_cast<Eigen::Index>(p));
      if (k != 0.0) coefficients[info.parameters[p].name] = k;
    }
    out.push_back({{"name", info.base.names[at]},
                   {"expression", info.base.expressions[at]},
                   {"value", info.base_values ? Json((*info.base_values)[j]) : Json()},
                   {"unit", info.parameters[own].unit},
                   {"coefficients", std::move(coefficients)}});
  }
  return out;
}

}  // namespace

std::string to_json(const RobotInfo& info) {
  const Model& arm = info.arm;
  Json out = json_head("info");
  out["robot"] = arm.name();
  out["source"] = arm.description().source;
  out["gravity"] = json_list(arm.gravity());
  out["impossible"] = physical_faults(arm);
  out["coordinates"] = coordinates_json(arm);
  out["frames"] = frames_json(arm);
  out["effects"] = effects_json(arm);
  out["standard_parameters"] = Json::array();
  for (std::size_t j = 0; j < info.parameters.size(); ++j) {
    const StandardParameter& p = info.parameters[j];
    out["standard_parameters"].push_back(
        {{"name", p.name}, {"unit", p.unit}, {"identifiable", name_of(info.base.classes[j])}});
  }
  out["base_parameters"] = base_json(info);
  out["rank_gap"] = info.base.rank_gap;
  out["identifiable_alone"] = parameters_of_class(info, Identifiability::kAlone);
  out["identifiable_in_combination"] = parameters_of_class(info, Identifiability::kInCombination);
  out["unidentifiable"] = parameters_of_class(info, Identifiability::kNot);
  return json_text(out);
}

}  // namespace veridyn
