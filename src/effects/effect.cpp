#include "veridyn/effects/effect.hpp"

#include <algorithm>
#include <cmath>

namespace veridyn {
namespace {

// Initial values for effects that do not give a grid.
const std::vector<double>& usual_lengths() {
  static const std::vector<double> kShares = {1e-3, 1e-2, 0.1};
  return kShares;
}

// Shares of the largest speed.
const std::vector<double>& usual_speeds() {
  static const std::vector<double> kShares = {0.02, 0.06, 0.2};
  return kShares;
}

std::vector<double> scaled_by(std::vector<double> shares, double by) {
  for (double& share : shares) share *= by;
  return shares;
}

// Points at a sixth, a half and five sixths of the search range.
std::vector<double> spread(const EffectShape& shape) {
  std::vector<double> out;
  for (const double share : {1.0 / 6.0, 0.5, 5.0 / 6.0}) {
    out.push_back(shape.logarithmic ? shape.lower * std::pow(shape.upper / shape.lower, share)
                                    : shape.lower + share * (shape.upper - shape.lower));
  }
  return out;
}

// Initial values of ShapeScale::kByUnit.
std::vector<double> scaled_choices(const EffectShape& shape, const AxisMotion& motion) {
  if (shape.unit_revolute == "rad") return scaled_by(usual_lengths(), motion.travel);
  if (shape.unit_revolute == "rad/s") return scaled_by(usual_speeds(), motion.speed);
  return spread(shape);
}

// Initial values of one constant; nullopt where the constant is not searched.
std::optional<std::vector<double>> choices(const EffectShape& shape, const AxisMotion& motion) {
  switch (shape.scale) {
    case ShapeScale::kMiddle:
      return {{motion.middle}};
    case ShapeScale::kWaves:
      return motion.waves ? *motion.waves : std::vector<double>{shape.initial_value(motion.type)};
    case ShapeScale::kAbsolute:
      return shape.grid;
    case ShapeScale::kTravel:
      return scaled_by(shape.grid, motion.travel);
    case ShapeScale::kSpeed:
      return scaled_by(shape.grid, motion.speed);
    case ShapeScale::kDuration: {
      if (motion.duration <= 0.0) return {{shape.initial_value(motion.type)}};
      std::vector<double> out = scaled_by(shape.grid, motion.duration);
      for (double& value : out) value = std::max(value, shape.lower);
      return out;
    }
    case ShapeScale::kByUnit:
      break;
  }
  if (!shape.searched) return std::nullopt;
  return scaled_choices(shape, motion);
}

}  // namespace

double EffectShape::initial_value(JointType type) const {
  return type == JointType::kPrismatic && initial_prismatic != 0.0 ? initial_prismatic : initial;
}

EffectTraits Effect::traits() const {
  ShapeValues values{};
  const std::vector<EffectShape> all = shapes();
  for (size_t i = 0; i < all.size(); ++i) values[i] = all[i].initial;
  return traits(values);
}

std::vector<ShapeChoice> Effect::grid(const AxisMotion& motion) const {
  std::vector<ShapeChoice> out{{}};
  for (const EffectShape& shape : shapes()) {
    const auto values = choices(shape, motion);
    if (!values) continue;
    std::vector<ShapeChoice> longer;
    for (const ShapeChoice& choice : out) {
      for (const double value : *values) {
        longer.push_back(choice);
        longer.back()[shape.name] = value;
      }
    }
    out = std::move(longer);
  }
  return out;
}

}  // namespace veridyn
