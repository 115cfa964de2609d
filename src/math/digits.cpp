#include "math/digits.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace veridyn {
namespace {

constexpr std::size_t kLongest = 400;  // decimals() of the largest double: 309 digits before the point

template <typename... Format>
std::string number_text(double value, Format... format) {
  std::array<char, kLongest> text{};
  return std::string(text.data(), std::to_chars(text.data(), text.data() + text.size(), value, format...).ptr);
}

}  // namespace

std::string digits(double value, int significant) {
  return number_text(value, std::chars_format::general, significant);
}

std::string decimals(double value, int after_point) {
  return number_text(value, std::chars_format::fixed, after_point);
}

std::string in_percent(double share, std::size_t width) {
  const std::string out = std::isfinite(share) ? decimals(100.0 * share, 2) : "-";
  return std::string(std::max(out.size(), width) - out.size(), ' ') + out;
}

std::string all_digits(double value) {
  return number_text(value);
}

}  // namespace veridyn
