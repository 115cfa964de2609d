#include "diagnosis/comparison/comparison_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "veridyn/effects/effect_facts.hpp"
#include "diagnosis/comparison/comparison_numbers.hpp"

namespace veridyn {
namespace {

// A number with the decimals that show two digits of its deviation.
std::string number_text(double value, double deviation) {
  const double least = deviation > 0.0 && std::isfinite(deviation) ? deviation : std::abs(value);
  if (!(least > 0.0) || !std::isfinite(value)) return fmt::format("{:.3g}", value);
  const int decimals = std::max(0, 1 - static_cast<int>(std::floor(std::log10(least))));
  if (decimals > comparing::kMostDecimals) return fmt::format("{:.3g}", value);
  return fmt::format("{:.{}f}", value, decimals);
}

// For example "grew from 0.40 to 0.48 N m (+20 %; by +0.08 N m, 95 %: +0.05 to +0.11)"; growth is ambiguous where a value
// is negative.
std::string change_text(const ModelDifference& d) {
  const bool known = std::isfinite(d.deviation);
  const double resolution = known ? d.deviation : comparing::kDigits * std::abs(d.before);
  const auto signed_text = [&](double value) { return (value > 0.0 ? "+" : "") + number_text(value, resolution); };
  const char* const verb = d.before <= 0.0 || d.after <= 0.0 ? "went" : d.after > d.before ? "grew" : "fell";
  std::string more;
  if (d.before > (known ? comparing::numbers.surely_there * d.deviation : 0.0) && d.after > 0.0) more = fmt::format("{:+.0f} %", 100.0 * (d.after / d.before - 1.0));
  if (known) {
    more += fmt::format("{}by {} {}, 95 %: {} to {}", more.empty() ? "" : "; ", signed_text(d.difference), d.unit, signed_text(d.low), signed_text(d.high));
  }
  return fmt::format("{} from {} to {} {}{}", verb, number_text(d.before, resolution), number_text(d.after, resolution), d.unit,
                     more.empty() ? "" : " (" + more + ")");
}

std::string joint_text(const Model& arm, JointIndex joint) {
  return fmt::format("joint {} ({})", joint.value + 1, arm.coordinates()[joint.value].name);
}

std::string effect_sentence(const Model& arm, const EffectTerm& term, const StandardParameter& p, const ModelDifference& d) {
  std::string name = term.effect;
  std::replace(name.begin(), name.end(), '_', ' ');
  name[0] = static_cast<char>(std::toupper(name[0]));
  const EffectFacts bound(arm, term);
  if (bound.parameter_count() > 1) name += " (" + bound.parameters()[p.component].name + ")";
  const bool one_joint = (term.axis.coefficients.array() != 0.0).count() == 1;
  return fmt::format("{} of {} {}.", name, one_joint ? joint_text(arm, d.joint) : "the axis " + axis_text(arm, term.axis), change_text(d));
}

// For example "joint 1 (yaw) changed by up to 0.10 N m, on joint 2 (pitch) by 0.08 N m": the main joint
// first, then the joints with the same unit and at least half of its change.
std::string joints_text(const Model& arm, const VectorXd& torque, JointIndex main) {
  const std::string unit = effort_unit(arm.coordinates()[main.value]);
  std::string out = fmt::format("{} changed by up to {} {}", joint_text(arm, main), number_text(torque[main.value], 0.0), unit);
  for (int i = 0; i < arm.joints(); ++i) {
    if (i == main.value || effort_unit(arm.coordinates()[i]) != unit || torque[i] < 0.5 * torque[main.value]) continue;
    out += fmt::format(", on {} by {} {}", joint_text(arm, {i}), number_text(torque[i], 0.0), unit);
  }
  return out;
}

std::string inertial_sentence(const Model& arm, const StandardTorque& torque, int standard, const ModelDifference& d) {
  const int component = torque.parameters[standard].component;
  const std::string out = fmt::format("The {} {}{} {}: ", component == 0 ? "mass" : component <= 3 ? "first moment" : "inertia", d.name,
                                      d.expression == d.name ? "" : " (with what cannot be told from it)", change_text(d));
  const VectorXd weight = torque.weight.col(standard);
  const Eigen::Index i = d.joint.value;
  if (weight[i] > 0.5 * torque.rms(i, standard)) return out + "weight on " + joints_text(arm, weight * std::abs(d.difference), d.joint) + ".";
  return out + fmt::format("{} feels it when the arm moves, {} {} rms over the standard motion.", joint_text(arm, d.joint),
                           number_text(d.torque[i], 0.0), effort_unit(arm.coordinates()[i]));
}

}  // namespace

std::string parameter_sentence(const Model& arm, const StandardTorque& torque, int standard, const ModelDifference& difference) {
  const StandardParameter& p = torque.parameters[standard];
  return p.effect ? effect_sentence(arm, arm.effects()[*p.effect], p, difference) : inertial_sentence(arm, torque, standard, difference);
}

std::string joint_sentence(const Model& arm, const JointQuantity& which, const ModelDifference& d) {
  return fmt::format("{} {} {}.", which.words, joint_text(arm, d.joint), change_text(d));
}

}  // namespace veridyn
