#include "effects/plain_friction.hpp"
#include "veridyn/report/robot_info.hpp"

#include <fmt/format.h>

#include <cmath>

#include "report/text_table.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/files/physical_faults.hpp"

namespace veridyn {
namespace {

constexpr Align kLeft = Align::kLeft;
constexpr Align kRight = Align::kRight;

// Text of a bound: "-1.58", or "-" if there is none.
std::string bound(double value) {
  return std::isfinite(value) ? fmt::format("{:.5g}", value) : "-";
}

std::string coordinates(const Model& arm) {
  TextTable table({kRight, kLeft, kRight, kRight, kLeft, kRight, kLeft, kRight, kLeft, kLeft});
  table.add({"", "coordinate", "from", "to", "", "speed", "", "effort", "", ""});
  int number = 0;
  for (const Coordinate& c : arm.coordinates()) {
    const std::string gain =
        c.drive_gain == 0.0 ? ""
                            : fmt::format("drive gain {:.6g} {}/A", c.drive_gain, effort_unit(c));
    table.add({std::to_string(++number), c.name, bound(c.limits.lower), bound(c.limits.upper),
               position_unit(c), bound(c.limits.velocity), position_unit(c) + "/s",
               bound(c.limits.effort), effort_unit(c), gain});
  }
  return table.text();
}

std::string variable_text(const Model& arm, const Frame& frame) {
  if (frame.type == JointType::kFixed) return "fixed";
  const char* motion = frame.type == JointType::kRevolute ? "turns by " : "slides by ";
  return motion + axis_text(arm, frame.variable);
}

std::string body_text(const Frame& frame) {
  if (!frame.body) return "";
  if (frame.body->fixed) return "body, values are facts";
  return frame.body->phi ? "body, with values" : "body";
}

std::string frame_table(const Model& arm) {
  TextTable table({kLeft, kLeft, kLeft, kLeft});
  table.add({"frame", "parent", "", "joint variable"});
  for (const Frame& frame : arm.frames()) {
    const std::string parent = frame.parent ? arm.frames()[frame.parent->value].name : "world";
    table.add({frame.name, parent, body_text(frame), variable_text(arm, frame)});
  }
  return table.text();
}

std::string effect_table(const Model& arm) {
  if (arm.effects().empty()) return paragraph({"no effects"});
  TextTable table({kLeft, kLeft, kLeft});
  table.add({"effect", "acts on", "values"});
  for (const EffectTerm& term : arm.effects()) {
    std::string values;
    for (const auto& [name, value] : term.values) values += fmt::format("{} {:.6g} ", name, value);
    const std::string place =
        term.frame.empty() ? axis_text(arm, term.axis) : "frame " + term.frame;
    table.add({term.effect, place, values});
  }
  return table.text();
}

std::string base_parameter_list(const RobotInfo& info) {
  TextTable table({kRight, kRight, kLeft, kLeft});
  table.add({"", info.base_values ? "value" : "", "unit", "base parameter"});
  for (int j = 0; j < info.base.size(); ++j) {
    const auto at = static_cast<std::size_t>(j);
    const auto own = static_cast<std::size_t>(info.base.independent[at]);
    const std::string value = info.base_values ? fmt::format("{:.6g}", (*info.base_values)[j]) : "";
    table.add({std::to_string(j + 1), value, info.parameters[own].unit, info.base.expressions[at]});
  }
  return table.text();
}

std::string class_list(const RobotInfo& info, const char* title, Identifiability class_wanted) {
  const std::vector<std::string> names = parameters_of_class(info, class_wanted);
  return fmt::format("\n{} ({})\n{}", title, names.size(), paragraph(names));
}

}  // namespace

RobotInfo robot_info(const Model& arm) {
  RobotInfo info{arm, standard_parameters(arm), base_parameters(arm), {}};
  if (!has_all_values(arm)) return info;
  VectorXd phi(info.parameters.size());
  for (Eigen::Index j = 0; j < phi.size(); ++j)
    phi[j] = info.parameters[j].value;
  info.base_values = info.base.K * phi;
  return info;
}

std::vector<std::string> parameters_of_class(const RobotInfo& info, Identifiability class_wanted) {
  std::vector<std::string> names;
  for (std::size_t j = 0; j < info.parameters.size(); ++j) {
    if (info.base.classes[j] == class_wanted) names.push_back(info.parameters[j].name);
  }
  return names;
}

std::string RobotInfo::report() const {
  std::string out =
      fmt::format("{}: {} coordinates, {} frames, {} bodies, {} effects\n", arm.name(),
                  arm.joints(), arm.frames().size(), arm.bodies().size(), arm.effects().size());
  if (!arm.description().source.empty())
    out += fmt::format("source: {}\n", arm.description().source);
  out += fmt::format("gravity: [{:g}, {:g}, {:g}] m/s^2\n", arm.gravity().x(), arm.gravity().y(),
                     arm.gravity().z());
  if (has_no_friction(arm))
    out += "no friction: the file has none, and every real joint has (identify --friction plain)\n";
  for (const std::string& fault : physical_faults(arm)) out += "impossible: " + fault + "\n";
  out += "\n" + coordinates(arm) + "\n" + frame_table(arm) + "\n" + effect_table(arm) + "\n";
  out += fmt::format("{} standard parameters, {} base parameters, rank gap {:.1e}\n",
                     parameters.size(), base.size(), base.rank_gap);
  out += base_parameter_list(*this);
  out += class_list(*this, "identifiable alone", Identifiability::kAlone);
  out += class_list(*this, "identifiable only in combination", Identifiability::kInCombination);
  out += class_list(*this, "unidentifiable", Identifiability::kNot);
  return out;
}

}  // namespace veridyn
