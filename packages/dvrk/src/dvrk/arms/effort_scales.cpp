#include "dvrk/arms/effort_scales.hpp"

#include <nlohmann/json.hpp>

#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

// Replaces the scale by that of an identified drive gain, and multiplies it by the recorded torque gain.
void correct_scale(const Coordinate& coordinate, EffortScale& scale) {
  if (coordinate.drive_gain > 0.0) {
    scale.scale = 1.0 / coordinate.drive_gain;
    scale.std_scale = coordinate.drive_gain_deviation * scale.scale * scale.scale;
    scale.source = "drive gain of " + coordinate.name;
  }
  const double gain = coordinate.recorded.torque_gain;
  if (gain == 1.0) return;
  scale.scale *= gain;
  scale.std_scale *= gain;
  scale.source += (scale.source.empty() ? "" : " and ") + ("torque gain of " + coordinate.name);
}

}  // namespace

std::vector<EffortScale> corrected_scales(const Model& model, const ArmFacts& arm,
                                          const RobotConfig& robot) {
  require(robot.actuators.size() == arm.actuators.size(), "robot '", robot.name, "': found ",
          robot.actuators.size(), " actuators, expected ", arm.actuators.size(), " of a ", arm.kind,
          ".");
  std::vector<EffortScale> scales;
  for (std::size_t k = 0; k < arm.actuators.size(); ++k) {
    EffortScale scale;
    scale.actuator = arm.actuators[k].name;
    scale.unit = arm.actuators[k].prismatic ? "A/N" : "A/N m";
    scale.before = robot.actuators[k].effort_to_amps;
    scale.scale = scale.before;
    if (const auto i = model.find_coordinate(scale.actuator)) correct_scale(model.coordinates()[i->value], scale);
    scales.push_back(scale);
  }
  return scales;
}

std::string to_scales_json(const std::string& arm, const std::vector<EffortScale>& scales) {
  using Json = nlohmann::ordered_json;
  Json actuators = Json::array();
  for (const EffortScale& scale : scales) {
    Json notes = {{"actuator", scale.actuator},
                  {"unit", scale.unit},
                  {"before", scale.before},
                  {"source", scale.source.empty() ? "unchanged" : scale.source}};
    if (scale.std_scale > 0.0) notes["std"] = scale.std_scale;
    actuators.push_back(
        {{"drive", {{"effort_to_current", {{"scale", scale.scale}}}}}, {"veridyn", notes}});
  }
  const Json file = {{"robots", Json::array({{{"name", arm}, {"actuators", actuators}}})}};
  return file.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace veridyn::dvrk
