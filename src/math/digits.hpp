#pragma once

#include <string>

namespace veridyn {

/// A number with `significant` digits, without trailing zeros: "0.0123", "1.5e-07".
std::string digits(double value, int significant);

/// A number with `after_point` digits after the point.
std::string decimals(double value, int after_point);

/// A share in per cent with two digits after the point, padded to `width`; a dash if it is not finite.
std::string in_percent(double share, std::size_t width = 0);

/// The shortest text from which the same number is read.
std::string all_digits(double value);

}  // namespace veridyn
