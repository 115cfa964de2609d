#pragma once

#include <string>
#include <vector>

#include "effects/phrase.hpp"
#include "effects/written_in_c.hpp"
#include "veridyn/effects/effect.hpp"

namespace veridyn {

/// Description of an effect along an axis, as data.
struct AxisEffectData {
  const char* name;
  std::vector<EffectParameter> parameters;
  std::vector<EffectShape> shapes;
  EffectTraits traits;
  void (*columns)(const AxisSample& x, const ShapeValues& shape, EffectState& state, EffectColumns& row) noexcept;
  /// Text of Effect::phrase(), where each % is the next parameter, each # the next constant, and $ is "force"
  /// or "torque".
  const char* phrase;
  /// A function that replaces `phrase`, for texts of another form.
  std::string (*words)(const Effect& effect, const std::vector<double>& values, const ShapeValues& shape, JointType type) = nullptr;
  bool imitates_others = false;
};

class DescribedEffect : public AxisEffect {
 public:
  explicit DescribedEffect(AxisEffectData data) : data_(std::move(data)) {}

  std::string name() const override { return data_.name; }
  std::vector<EffectParameter> parameters() const override { return data_.parameters; }
  std::vector<EffectShape> shapes() const override { return data_.shapes; }
  EffectTraits traits(const ShapeValues& /*shape*/) const override { return data_.traits; }
  bool imitates_others() const override { return data_.imitates_others; }
  void columns(const AxisSample& x, const ShapeValues& shape, EffectState& state, EffectColumns& row) const noexcept override {
    data_.columns(x, shape, state, row);
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& shape, JointType type) const override;

 private:
  AxisEffectData data_;
};

/// A DescribedEffect with its columns in C, where #0 and #1 stand for the values of its constants.
class DescribedEffectInC : public DescribedEffect, public WrittenInC {
 public:
  /// @param before  code before the columns, see c_before().
  DescribedEffectInC(AxisEffectData data, std::vector<std::string> c_columns, std::string before = {})
      : DescribedEffect(std::move(data)), c_columns_(std::move(c_columns)), before_(std::move(before)) {}

  std::vector<std::string> c_columns(const ShapeValues& shape) const override;
  std::string c_before(const ShapeValues& shape) const override;

 private:
  std::vector<std::string> c_columns_;
  std::string before_;
};

}  // namespace veridyn
