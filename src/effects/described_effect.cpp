#include "effects/described_effect.hpp"

namespace veridyn {
namespace {

// C code in which each #k is replaced by shape constant k.
std::string with_constants(const std::string& words, const ShapeValues& shape) {
  std::string out;
  for (std::size_t k = 0; k < words.size(); ++k) out += words[k] == '#' ? c_number(shape[words[++k] - '0']) : std::string(1, words[k]);
  return out;
}

}  // namespace

std::string DescribedEffect::phrase(const std::vector<double>& values, const ShapeValues& shape, JointType type) const {
  if (data_.words != nullptr) return data_.words(*this, values, shape, type);
  std::string out;
  std::size_t parameter = 0, constant = 0;
  for (const char c : std::string(data_.phrase)) {
    if (c == '%') out += parameter_text(*this, values, parameter++, type);
    else if (c == '#') out += shape_text(*this, shape, constant++, type);
    else out += c == '$' ? effort_word(type) : std::string(1, c);
  }
  return out;
}

std::vector<std::string> DescribedEffectInC::c_columns(const ShapeValues& shape) const {
  std::vector<std::string> out;
  for (const std::string& column : c_columns_) out.push_back(with_constants(column, shape));
  return out;
}

std::string DescribedEffectInC::c_before(const ShapeValues& shape) const { return with_constants(before_, shape); }

}  // namespace veridyn
