#pragma once

#include <string>
#include <vector>

#include "veridyn/effects/effect.hpp"

namespace veridyn {

/// A number with at least two digits and its unit, in thousandths where it is small: "0.50 N",
/// "0.14 mm", "12 mN m".
std::string text_with_unit(double value, const std::string& unit);

/// text_with_unit() of parameter p, and likewise of shape constant i.
std::string parameter_text(const Effect& effect, const std::vector<double>& values, size_t p,
                           JointType type);
std::string shape_text(const Effect& effect, const ShapeValues& shape, size_t i, JointType type);

/// text_with_unit() of an effort [N m] or [N].
std::string effort_text(double effort, JointType type);

/// The word for an effort: "torque" or "force".
std::string effort_word(JointType type);

}  // namespace veridyn
