#include "diagnosis/comparison/comparison_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "veridyn/effects/effect_facts.hpp"
#include "diagnosis/comparison/comparison_numbers.hpp"

namespace veridyn {
namespace {

std::string change_verb(const ModelDifference& d) {
  // "Grew" and "fell" are ambiguous where a value is negative.
  if (!(d.before > 0.0 && d.after > 0.0)) return "went";
  return d.after > d.before ? "grew" : "fell";
}

std::string signed_text(double value, double resolution) {
  return (value > 0.0 ? "+" : "") + number_text(value, resolution);
}

// for example "from 0.40 to 0.48 N m (+20 %; by +0.08 N m, 95 %: +0.05 to +0.11)"
std::string sizes_text(const ModelDifference& d) {
  const double resolution = std::isfinite(d.deviation) ? d.deviation : comparing::kDigits * std::abs(d.before);
  std::string out = fmt::format("from {} to {} {}", number_text(d.before, resolution),
                                number_text(d.after, resolution), d.unit);
  std::string more;
  const double known = std::isfinite(d.deviation) ? comparing::numbers.surely_there * d.deviation : 0.0;
  if (d.before > known && d.after > 0.0)
    more = fmt::format("{:+.0f} %", 100.0 * (d.after / d.before - 1.0));
  if (std::isfinite(d.deviation)) {
    more += fmt::format("{}by {} {}, 95 %: {} to {}", more.empty() ? "" : "; ",
                        signed_text(d.difference, resolution), d.unit,
                        signed_text(d.low, resolution), signed_text(d.high, resolution));
  }
  return more.empty() ? out : out + " (" + more + ")";
}

std::string capitalised(std::string words) {
  if (words[0] >= 'a' && words[0] <= 'z') words[0] = static_cast<char>(words[0] - 'a' + 'A');
  return words;
}

std::string joint_text(const Model& arm, JointIndex joint) {
  return fmt::format("joint {} ({})", joint.value + 1, arm.coordinates()[joint.value].name);
}

std::string effect_sentence(const Model& arm, const EffectTerm& term, const StandardParameter& p,
                            const ModelDifference& d) {
  std::string name = term.effect;
  std::replace(name.begin(), name.end(), '_', ' ');
  if (name.rfind("coulomb", 0) == 0 || name.rfind("stribeck", 0) == 0) name[0] -= 'a' - 'A';
  const EffectFacts bound(arm, term);
  std::string which = bound.parameter_count() > 1
                          ? " (" + bound.parameters()[p.component].name + ")"
                          : "";
  std::string joints;
  for (int i = 0; i < arm.joints(); ++i) {
    if (term.axis.coefficients[i] == 0.0) continue;
    joints += (joints.empty() ? "" : ", ") + std::to_string(i + 1);
  }
  const bool one_joint = (term.axis.coefficients.array() != 0.0).count() == 1;
  const std::string where =
      one_joint ? joint_text(arm, d.joint)
                : "the axis " + axis_text(arm, term.axis) + " (joints " + joints + ")";
  return fmt::format("{}{} of {} {} {}.", name, which, where, change_verb(d), sizes_text(d));
}

// For example "joint 1 (yaw) changed by up to 0.10 N m, on joint 2 (pitch) by 0.08 N m": the main joint
// first, then the joints with the same unit and at least half of its change.
std::string joints_text(const Model& arm, const VectorXd& torque, JointIndex main) {
  const auto unit = [&arm](JointIndex joint) {
    return effort_unit(arm.coordinates()[joint.value]);
  };
  std::string out = fmt::format("{} changed by up to {} {}", joint_text(arm, main),
                                number_text(torque[main.value], 0.0), unit(main));
  for (int i = 0; i < arm.joints(); ++i) {
    const JointIndex joint{i};
    if (joint == main || unit(joint) != unit(main) || torque[i] < 0.5 * torque[main.value]) continue;
    out += fmt::format(", on {} by {} {}", joint_text(arm, joint),
                       number_text(torque[i], 0.0), unit(joint));
  }
  return out;
}

std::string inertial_sentence(const Model& arm, const StandardTorque& torque,
                              const StandardParameter& p, int standard, const ModelDifference& d) {
  const bool alone = d.expression == d.name;
  const std::string with = alone ? "" : " (with what cannot be told from it)";
  const char* const kind = p.component == 0   ? "the mass "
                           : p.component <= 3 ? "the first moment "
                                              : "the inertia ";
  std::string out =
      kind + d.name + with + " " + (change_verb(d) == "went" ? "went " : "changed ") + sizes_text(d) + ": ";
  const VectorXd weight = torque.weight_of(standard);
  const auto i = static_cast<Eigen::Index>(d.joint.value);
  if (weight[i] > 0.5 * torque.rms_of(standard)[i]) {
    return out + "weight on " + joints_text(arm, weight * std::abs(d.difference), d.joint) + ".";
  }
  return out + fmt::format("{} feels it when the arm moves, {} {} rms over the standard motion.",
                           joint_text(arm, d.joint), number_text(d.torque[i], 0.0),
                           effort_unit(arm.coordinates()[i]));
}

}  // namespace

std::string number_text(double value, double deviation) {
  const double least = deviation > 0.0 && std::isfinite(deviation) ? deviation : std::abs(value);
  if (!(least > 0.0) || !std::isfinite(value)) return fmt::format("{:.3g}", value);
  // Decimals that show two digits of the deviation.
  const int decimals = std::max(0, 1 - static_cast<int>(std::floor(std::log10(least))));
  if (decimals > comparing::kMostDecimals) return fmt::format("{:.3g}", value);
  return fmt::format("{:.{}f}", value, decimals);
}

std::string parameter_sentence(const Model& arm, const StandardTorque& torque, int standard,
                               const ModelDifference& difference) {
  const StandardParameter& p = torque.parameters()[standard];
  return capitalised(
      p.effect
          ? effect_sentence(arm, arm.effects()[*p.effect], p, difference)
          : inertial_sentence(arm, torque, p, standard, difference));
}

std::string joint_sentence(const Model& arm, JointQuantity which, const ModelDifference& d) {
  const char* what = "";
  switch (which) {
    case JointQuantity::kFriction:
      what = "friction of";
      break;
    case JointQuantity::kOffset:
      what = "the constant torque of";
      break;
    case JointQuantity::kWeight:
      what = "the weight that rests on";
      break;
    case JointQuantity::kWeightSlope:
      what = arm.coordinates()[d.joint.value].prismatic
                 ? "the part of the weight that follows the position of"
                 : "the part of the weight that follows the angle of";
      break;
    case JointQuantity::kInertia:
      what = "the inertia of";
      break;
  }
  return capitalised(
      fmt::format("{} {} {} {}.", what, joint_text(arm, d.joint), change_verb(d), sizes_text(d)));
}

}  // namespace veridyn
