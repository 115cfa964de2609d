#include <algorithm>

#include "effects/described_effect.hpp"
#include "registry.hpp"

namespace veridyn {
namespace {

constexpr int kFirstTerm = 2;
constexpr int kTerms = 4;

// Computes the terms by T_k = 2 x T_(k-1) - T_(k-2).
void chebyshev_terms(double x, EffectColumns& row) noexcept {
  double before = 1.0;
  double now = x;
  for (int k = kFirstTerm; k < kFirstTerm + kTerms; ++k) {
    const double next = 2.0 * x * now - before;
    row[k - kFirstTerm] = next;
    before = now;
    now = next;
  }
}

std::string describe_position_force(const Effect&, const std::vector<double>& values, const ShapeValues&, JointType type) {
  double lowest = 0.0;
  double highest = 0.0;
  constexpr int kPoints = 200;
  for (int i = 0; i <= kPoints; ++i) {
    EffectColumns row{};
    chebyshev_terms(2.0 * i / kPoints - 1.0, row);
    double effort = 0.0;
    for (size_t k = 0; k < kTerms; ++k) effort += row[k] * values[k];
    lowest = i == 0 ? effort : std::min(lowest, effort);
    highest = i == 0 ? effort : std::max(highest, effort);
  }
  return "a " + effort_word(type) + " that depends on position, between " +
         effort_text(lowest, type) + " and " + effort_text(highest, type);
}

}  // namespace

/// Any smooth force that depends on position beyond a constant and a linear term: harnesses, hoses,
/// counter-springs.
///
///   tau = sum_k chebyshev_k T_k(x),   x = (s - centre) / half_range,   k = 2 ... 5
///
/// T_0 is torque_offset and T_1 is joint_spring with an offset. Outside centre +- half_range, which
/// the caller takes from the data, the force is constant, because polynomials must not extrapolate.
const Effect& position_force() {
  EffectTraits t;
  t.uses_position = true;
  t.depends_on_position = true;
  t.holds_at_rest = true;
  t.lasting = true;
  t.mixed_axes = true;
  EffectShape centre{"centre", "rad", "m", 0.0, -10.0, 10.0, false, false};
  centre.scale = ShapeScale::kMiddle;
  EffectShape half_range{"half_range", "rad", "m", 1.0, 1e-3, 10.0, true, false, 0.1};
  half_range.scale = ShapeScale::kTravel;
  half_range.grid = {0.5};
  std::vector<EffectParameter> parameters;
  std::vector<std::string> c_columns;
  for (int k = kFirstTerm; k < kFirstTerm + kTerms; ++k) {
    parameters.push_back({"chebyshev_" + std::to_string(k), "N m", "N"});
    c_columns.push_back("cos(" + std::to_string(k) + ".0 * acos(@clamp((s - #0) / #1)))");
  }
  static const DescribedEffectInC kEffect({"position_force", parameters, {centre, half_range}, t,
      [](const AxisSample& x, const ShapeValues& shape, EffectState&, EffectColumns& row) noexcept {
        chebyshev_terms(std::clamp((x.s - shape[0]) / shape[1], -1.0, 1.0), row);
      },
      nullptr, describe_position_force}, c_columns);
  return kEffect;
}

}  // namespace veridyn
