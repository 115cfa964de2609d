#include <algorithm>
#include <cmath>

#include "math/digits.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"

namespace veridyn {
namespace {

bool are_equal_axes(const Axis& a, const Axis& b) {
  return a.coefficients == b.coefficients && a.offset == b.offset;
}

// True for one effect along the same axis and from the same source, with any constants.
bool same_place(const EffectTerm& a, const EffectTerm& b) {
  if (a.effect != b.effect || !are_equal_axes(a.axis, b.axis) || a.from.has_value() != b.from.has_value())
    return false;
  return !a.from || are_equal_axes(*a.from, *b.from);
}

// The text ", distance 0.005" if the arm also has the effect on this axis with other constants; else empty.
std::string constants_text(const Model& arm, const EffectTerm& term,
                           const std::vector<EffectShape>& shapes) {
  const auto given = [](const EffectTerm& of, const std::string& key) {
    const auto it = of.values.find(key);
    return it == of.values.end() ? std::string() : digits(it->second, 4);
  };
  std::string out;
  for (const EffectShape& shape : shapes) {
    bool differs = false;
    for (const EffectTerm& other : arm.effects()) {
      differs = differs ||
                (same_place(other, term) && given(other, shape.name) != given(term, shape.name));
    }
    if (differs && term.values.count(shape.name) > 0)
      out += ", " + shape.name + " " + given(term, shape.name);
  }
  return out;
}

// Throws InvalidInput for a key that the effect does not have, or a value that is not finite.
void require_known_keys(const EffectTerm& term, const std::string& where,
                        const std::vector<EffectShape>& shapes,
                        const std::vector<EffectParameter>& parameters) {
  std::vector<std::string> known;
  known.reserve(parameters.size() + shapes.size());
  for (const EffectParameter& p : parameters) known.push_back(p.name);
  for (const EffectShape& s : shapes) known.push_back(s.name);
  for (const auto& [key, value] : term.values) {
    require(std::find(known.begin(), known.end(), key) != known.end(), where, "effect '",
            term.effect, "' has no '", key, "'", did_you_mean(key, known),
            "; it has: ", listed(known), ".");
    require(std::isfinite(value), where, "effect '", term.effect, "': ", key, " is ", value,
            ", expected a finite number.");
  }
}

void replace_all(std::string& text, const std::string& what, const std::string& by) {
  for (size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size())) {
    text.replace(at, what.size(), by);
  }
}

}  // namespace

std::string axis_text(const Model& arm, const Axis& axis) {
  std::string out;
  for (int i = 0; i < arm.joints(); ++i) {
    const double c = axis.coefficients[i];
    if (c == 0.0) continue;
    if (!out.empty()) out += c < 0.0 ? " - " : " + ";
    if (out.empty() && c < 0.0) out += "-";
    if (std::abs(c) != 1.0) out += digits(std::abs(c), 6) + " ";
    out += arm.coordinates()[i].name;
  }
  if (axis.offset != 0.0)
    out += (axis.offset < 0.0 ? " - " : " + ") + digits(std::abs(axis.offset), 6);
  return out.empty() ? "0" : out;
}

BoundEffect::BoundEffect(const Model& arm, const EffectTerm& term)
    : effect_(&find_axis_effect(term.effect)),
      term_(term),
      parameters_(effect_->parameters()),
      label_(axis_text(arm, term.axis)),
      type_(is_prismatic(arm, term.axis) ? JointType::kPrismatic : JointType::kRevolute) {
  const std::string where = term.where.empty() ? "" : term.where + ": ";
  const std::vector<EffectShape> shapes = effect_->shapes();
  require_known_keys(term, where, shapes, parameters_);
  for (size_t i = 0; i < shapes.size(); ++i) {
    const EffectShape& s = shapes[i];
    shape_[i] = s.initial_value(type_);
    const auto given = term.values.find(s.name);
    if (given == term.values.end()) continue;
    shape_[i] = given->second;
    require(!s.logarithmic || shape_[i] > 0.0 || shape_[i] == s.initial, where, "effect '",
            term.effect, "': ", s.name, " is ", shape_[i], ", expected a number above 0.");
  }
  traits_ = effect_->traits(shape_);
  require(!traits_.uses_source || term.from.has_value(), where, "effect '", term.effect,
          "' needs `from: {coordinate: 1}`, the coordinate that it comes from.");
  size_t used = 0;
  for (size_t p = 0; p < parameters_.size(); ++p) {
    const auto given = term.values.find(parameters_[p].name);
    if (given == term.values.end()) continue;
    values_[p] = given->second;
    ++used;
  }
  has_values_ = used == parameters_.size();
  if (traits_.uses_source) {
    label_ += " from " + axis_text(arm, *term.from);
    source_unit_ = is_prismatic(arm, *term.from) ? "m" : "rad";
    for (EffectParameter& p : parameters_) {
      replace_all(p.unit_revolute, kSourceUnit, source_unit_);
      replace_all(p.unit_prismatic, kSourceUnit, source_unit_);
    }
  }
  label_ += constants_text(arm, term, shapes);
}

const std::string& BoundEffect::unit(int p) const {
  const EffectParameter& parameter = parameters_[p];
  return type_ == JointType::kPrismatic ? parameter.unit_prismatic : parameter.unit_revolute;
}

std::string BoundEffect::parameter_name(int p) const {
  return effect_->name() + "(" + label_ + ")." + parameters_[p].name;
}

namespace {

// The axis in words: "joint 3", or "joint 2 + 0.5 joint 3".
std::string joints_text(const Axis& axis) {
  std::string out;
  for (Eigen::Index i = 0; i < axis.coefficients.size(); ++i) {
    const double c = axis.coefficients[i];
    if (c == 0.0) continue;
    if (!out.empty() || c < 0.0) out += c < 0.0 ? (out.empty() ? "-" : " - ") : " + ";
    if (std::abs(c) != 1.0) out += digits(std::abs(c), 3) + " ";
    out += "joint " + std::to_string(i + 1);
  }
  return out;
}

}  // namespace

std::string BoundEffect::phrase(const std::vector<double>& values) const {
  require(values.size() == parameters_.size(), "phrase: ", values.size(), " values, but effect '",
          effect_->name(), "' has ", parameters_.size(), " parameters.");
  std::string out = effect_->phrase(values, shape_, type_);
  replace_all(out, kSourceUnit, source_unit_);
  if (term_.from) replace_all(out, "another joint", joints_text(*term_.from));
  if ((term_.axis.coefficients.array() != 0.0).count() > 1) out += " along " + joints_text(term_.axis);
  return out;
}

AxisSample BoundEffect::sample(double time, const double* q, const double* dq, const double* ddq,
                               long stride) const noexcept {
  AxisSample x;
  x.time = time - start_time_;
  x.s = term_.axis.offset;
  const auto n = static_cast<long>(term_.axis.coefficients.size());
  for (long i = 0; i < n; ++i) {
    const double c = term_.axis.coefficients[i];
    if (c == 0.0) continue;
    x.s += c * q[i * stride];
    x.ds += c * dq[i * stride];
    x.dds += c * ddq[i * stride];
  }
  if (!term_.from) return x;
  x.from_s = term_.from->offset;
  for (long i = 0; i < n; ++i) {
    const double c = term_.from->coefficients[i];
    x.from_s += c * q[i * stride];
    x.from_ds += c * dq[i * stride];
  }
  return x;
}

double BoundEffect::force(const AxisSample& sample) noexcept {
  EffectColumns row{};
  columns(sample, row);
  double sum = 0.0;
  for (size_t p = 0; p < parameters_.size(); ++p) sum += row[p] * values_[p];
  return sum;
}

double BoundEffect::inertia() const noexcept {
  AxisSample x;
  x.dds = 1.0;
  EffectState state{};
  EffectColumns row{};
  effect_->columns(x, shape_, state, row);
  double sum = 0.0;
  for (size_t p = 0; p < parameters_.size(); ++p) sum += row[p] * values_[p];
  return sum;
}

}  // namespace veridyn
