#pragma once

#include <string>
#include <vector>

#include "files/expression.hpp"
#include "veridyn/model/model.hpp"
#include "files/words.hpp"

namespace veridyn {

constexpr double kYamlRounding =
    1e-15;  ///< rounding error allowed in a file, relative to 1 + |number|

bool same_in_yaml(double a, double b);  ///< equal but for the rounding of files

/// Zero for a number far below the rounding of poses, whose entries are about 1.
double without_noise(double value);

/// A scalar that YAML reads as text, also inside {} and [].
std::string quoted_if_needed(const std::string& word);

/// The shortest text that is read back as the same number; .inf and -.inf where it is infinite.
std::string shortest(double value);

/// True if the expression has that value.
bool formula_gives(const std::string& formula, const Constants& constants, double value);

/// Writes numbers of a model's file, as the expression in the original file if it still has the same value.
class YamlNumbers {
 public:
  explicit YamlNumbers(const ModelDescription& arm) : arm_(arm) {}

  /// @param place  as in ModelDescription::formulas.
  /// @throws InvalidInput  the value is not finite.
  std::string number(const std::string& place, double value) const;

  /// Writes an angle, with right angles as multiples of pi.
  std::string angle(const std::string& place, double value) const;

  /// "[x, y, z]", without noise.
  std::string vector(const std::string& place, const Vec3d& v) const;

  template <typename Values>
  std::string list(const std::string& place, const Values& values) const {
    std::vector<std::string> texts;
    for (const double value : values)
      texts.push_back(number(place + "/" + std::to_string(texts.size()), value));
    return "[" + joined(texts) + "]";
  }

 private:
  const ModelDescription& arm_;
};

}  // namespace veridyn
