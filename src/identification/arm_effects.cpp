#include "veridyn/identification/arm_effects.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

const std::map<std::string, std::vector<EffectParameter>>& table() {
  static const std::map<std::string, std::vector<EffectParameter>> kTable = {
      {"torque_gain", {{"error", "1", "1"}}},
      {"time_delay", {{"seconds", "s", "s"}}},
      {"encoder_offset", {{"offset", "rad", "m"}}},
      {"gravity_tilt", {{"roll", "rad", "rad"}, {"pitch", "rad", "rad"}}}};
  return kTable;
}

}  // namespace

bool is_arm_effect(const std::string& name) {
  return table().count(name) != 0;
}

const std::vector<EffectParameter>& arm_effect_parameters(const std::string& name) {
  const auto found = table().find(name);
  require(found != table().end(), "'", name, "' is not an effect of the whole arm.");
  return found->second;
}

std::string arm_effect_parameter_name(const Model& arm, const EffectTerm& term, int p) {
  const std::string place = term.effect == "gravity_tilt" ? "arm" : axis_text(arm, term.axis);
  return fmt::format("{}({}).{}", term.effect, place,
                     arm_effect_parameters(term.effect)[static_cast<size_t>(p)].name);
}

bool arm_effect_acts_on(const EffectTerm& term, int joint) {
  const bool one_joint = term.effect == "torque_gain" || term.effect == "time_delay";
  return !one_joint || term.axis.coefficients[joint] != 0.0;
}

std::string arm_effect_phrase(const Model& arm, const EffectTerm& term,
                              const std::vector<double>& values) {
  if (term.effect == "torque_gain")
    return fmt::format("a recorded torque that is {:.2g} % too {}", 100.0 * std::abs(values[0]),
                       values[0] > 0.0 ? "large" : "small");
  if (term.effect == "time_delay")
    return fmt::format("a recorded torque that comes {:.2g} ms too {}", 1e3 * std::abs(values[0]),
                       values[0] > 0.0 ? "late" : "early");
  if (term.effect == "encoder_offset") {
    const bool slides = is_prismatic(arm, term.axis);
    return fmt::format("a recorded position that is {:.3g} {} too {}", 1e3 * std::abs(values[0]),
                       slides ? "mm" : "mrad", values[0] > 0.0 ? "large" : "small");
  }
  return fmt::format("a base that leans by {:.3g} mrad about x and {:.3g} mrad about y",
                     1e3 * values[0], 1e3 * values[1]);
}

Eigen::Vector3d tilted_gravity_change(const Eigen::Vector3d& gravity, double roll, double pitch) {
  // R' g - g for R = Ry(pitch) Rx(roll).
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
                                .toRotationMatrix();
  return R.transpose() * gravity - gravity;
}

Model with_arm_effect(const Model& arm, const EffectTerm& term, const std::vector<double>& values) {
  ModelDescription d = arm.description();
  if (term.effect == "gravity_tilt") {
    d.gravity += tilted_gravity_change(d.gravity, values[0], values[1]);
    return Model(std::move(d));
  }
  RecordedChannel& channel =
      d.coordinates[static_cast<size_t>(main_coordinate(term.axis))].recorded;
  if (term.effect == "torque_gain") channel.torque_gain *= 1.0 + values[0];
  if (term.effect == "time_delay") channel.torque_delay += values[0];
  if (term.effect == "encoder_offset") channel.position_offset += values[0];
  return Model(std::move(d));
}

}  // namespace veridyn
