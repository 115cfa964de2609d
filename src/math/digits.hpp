#pragma once

#include <string>

namespace veridyn {

/// A number with that many significant digits, without trailing zeros: "0.0123", "1.5e-07".
std::string digits(double value, int significant);

/// A number with that many digits after the point.
std::string decimals(double value, int after_point);

/// A share in per cent with two digits after the point, at least that wide; a dash where it is not finite.
std::string in_percent(double share, std::size_t width = 0);

/// The shortest text that is read back as the same number.
std::string all_digits(double value);

}  // namespace veridyn
