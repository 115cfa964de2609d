#include "effects/written_in_c.hpp"

#include "math/digits.hpp"

namespace veridyn {

std::string c_number(double value) {
  std::string number = all_digits(value + 0.0);
  if (number.find_first_of(".en") == std::string::npos) number += ".0";
  return value < 0.0 ? "(" + number + ")" : number;
}

}  // namespace veridyn
