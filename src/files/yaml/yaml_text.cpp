#include "files/yaml/yaml_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn {

bool same_in_yaml(double a, double b) {
  return a == b || (std::isfinite(b) && std::abs(a - b) <= kYamlRounding * (1.0 + std::abs(b)));
}

double without_noise(double value) {
  return std::abs(value) < 0.1 * kYamlRounding ? 0.0 : value;
}

namespace {

// True for plain words that YAML 1.1 or 1.2 reads as null, a truth value or a number.
bool has_another_meaning(const std::string& word) {
  std::string lower = word;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const std::array<const char*, 9> words{"null", "true", "false", "yes", "no",
                                         "on",   "off",  "y",     "n"};
  std::string digits = word;
  digits.erase(std::remove(digits.begin(), digits.end(), '_'), digits.end());
  return number_in(digits).has_value() || std::find(words.begin(), words.end(), lower) != words.end();
}

}  // namespace

std::string quoted_if_needed(const std::string& word) {
  const std::string alphanumeric = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789";
  const std::size_t first = word.find_first_of(alphanumeric);
  const bool plain = word.find_first_not_of(alphanumeric + "_-+*/^(). ") == std::string::npos &&
                     (first == 0 || (first == 1 && (word[0] == '-' || word[0] == '('))) &&
                     word.back() != ' ' && !has_another_meaning(word);
  if (plain) return word;
  std::string quoted = "\"";
  for (const char c : word) {
    if (static_cast<unsigned char>(c) < 0x20) {
      quoted += fmt::format("\\x{:02x}", static_cast<unsigned>(c));
    } else {
      if (c == '"' || c == '\\') quoted += '\\';
      quoted += c;
    }
  }
  return quoted + "\"";
}

std::string shortest(double value) {
  if (std::isinf(value)) return value > 0.0 ? ".inf" : "-.inf";
  return fmt::format("{}", value + 0.0);  // + 0.0: no negative zero
}

bool formula_gives(const std::string& formula, const Constants& constants, double value) {
  try {
    return same_in_yaml(evaluate(formula, constants), value);
  } catch (const InvalidInput&) {
    return false;
  }
}

std::string YamlNumbers::number(const std::string& place, double value) const {
  const auto formula = arm_.formulas.find(place);
  if (formula != arm_.formulas.end() && formula_gives(formula->second, arm_.constants, value)) {
    return number_in(formula->second) ? formula->second : quoted_if_needed(formula->second);
  }
  require(std::isfinite(value), "to_yaml: ", place, " of arm '", arm_.name, "' is ", value,
          ", but a file holds finite numbers.");
  return shortest(value);
}

std::string YamlNumbers::angle(const std::string& place, double value) const {
  if (same_in_yaml(value, M_PI)) return "pi";
  if (same_in_yaml(value, -M_PI)) return "-pi";
  if (same_in_yaml(value, M_PI / 2)) return "pi/2";
  if (same_in_yaml(value, -M_PI / 2)) return "-pi/2";
  return number(place, without_noise(value));
}

std::string YamlNumbers::vector(const std::string& place, const Vec3d& v) const {
  return list(place,
              std::vector<double>{without_noise(v.x), without_noise(v.y), without_noise(v.z)});
}

}  // namespace veridyn
