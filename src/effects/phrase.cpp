#include "phrase.hpp"

#include <algorithm>
#include <cmath>

#include "math/digits.hpp"

namespace veridyn {
namespace {

constexpr double kSmall = 0.1;  // smaller values are written in thousandths

std::string two_digits(double value) {
  if (value == 0.0 || !std::isfinite(value)) return all_digits(value);
  const int after_point = std::max(0, 1 - static_cast<int>(std::floor(std::log10(std::abs(value)))));
  return decimals(value, after_point);
}

// False if the unit begins with a power, to which a prefix would apply as well: no "ms^2".
bool accepts_prefix(const std::string& unit) {
  const std::string first = unit.substr(0, unit.find_first_of(" /"));
  return first == "N" || first == "rad" || first == "m" || first == "s";
}

}  // namespace

std::string text_with_unit(double value, const std::string& unit) {
  if (unit == "1") return two_digits(value);
  const bool small = value != 0.0 && std::abs(value) < kSmall;
  if (small && unit == "kg") return two_digits(1e3 * value) + " g";
  if (small && accepts_prefix(unit)) return two_digits(1e3 * value) + " m" + unit;
  return two_digits(value) + " " + unit;
}

std::string parameter_text(const Effect& effect, const std::vector<double>& values, size_t p,
                           JointType type) {
  const EffectParameter parameter = effect.parameters()[p];
  return text_with_unit(values[p], type == JointType::kPrismatic ? parameter.unit_prismatic
                                                                 : parameter.unit_revolute);
}

std::string shape_text(const Effect& effect, const ShapeValues& shape, size_t i, JointType type) {
  const EffectShape constant = effect.shapes()[i];
  return text_with_unit(shape[i],
                        type == JointType::kPrismatic ? constant.unit_prismatic : constant.unit_revolute);
}

std::string effort_text(double effort, JointType type) {
  return text_with_unit(effort, type == JointType::kPrismatic ? "N" : "N m");
}

std::string effort_word(JointType type) {
  return type == JointType::kPrismatic ? "force" : "torque";
}

}  // namespace veridyn
