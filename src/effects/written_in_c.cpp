#include "effects/written_in_c.hpp"

#include <fmt/format.h>

namespace veridyn {

std::string c_number(double value) {
  std::string digits = fmt::format("{}", value + 0.0);
  if (digits.find_first_of(".en") == std::string::npos) digits += ".0";
  return value < 0.0 ? "(" + digits + ")" : digits;
}

}  // namespace veridyn
