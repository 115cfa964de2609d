#include "diagnosis/causes/extended_arm.hpp"

#include <algorithm>
#include <string>

#include "diagnosis/evidence/effect_facts.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/channel_effect.hpp"

namespace veridyn {
namespace {

void add_load(const FoundCause& found, int joints, ModelDescription& d) {
  const auto known = [&d](const std::string& name) {
    return std::any_of(d.frames.begin(), d.frames.end(),
                       [&name](const Frame& f) { return f.name == name; });
  };
  Frame load;
  load.name = AddedLoad::kName;
  for (int count = 2; known(load.name); ++count)
    load.name = std::string(AddedLoad::kName) + "_" + std::to_string(count);
  load.parent = frame_of(found.hypothesis.cause);
  load.variable.coefficients = VectorXd::Zero(joints);
  load.body = Body{};
  load.body->phi = found.load;
  d.frames.push_back(std::move(load));
}

void change(EffectTerm& own, const std::vector<double>& by) {
  const std::vector<EffectParameter> parameters = find_effect(own.effect).parameters();
  for (size_t p = 0; p < parameters.size(); ++p) {
    double& value = own.values[parameters[p].name];
    value += by[p];
    if (parameters[p].sign == ParameterSign::kNonnegative) value = std::max(value, 0.0);
  }
  own.deviations.clear();
}

EffectTerm with_values(EffectTerm term, const std::vector<double>& values) {
  const std::vector<EffectParameter> parameters = find_effect(term.effect).parameters();
  for (size_t p = 0; p < parameters.size(); ++p) term.values[parameters[p].name] = values[p];
  return term;
}

}  // namespace

Model extended_arm(const Model& arm, const std::vector<FoundCause>& found, bool changes) {
  ModelDescription d = arm.description();
  if (changes) d.identified.reset();  // the statistics belong to values that have changed
  for (const FoundCause& f : found) {
    const Hypothesis& h = f.hypothesis;
    if (is_load(h)) {
      add_load(f, arm.joints(), d);
    } else if (is_change(h)) {
      change(d.effects[h.own->value], f.values);
    } else if (is_other_constant(h)) {
      d.effects[h.own->value] = f.term;  // beside each other the two would share their size
    } else if (!is_channel(h)) {
      d.effects.push_back(changes ? with_values(f.term, f.values) : f.term);
    }
  }
  Model out(std::move(d));
  for (const FoundCause& f : found) {
    if (is_channel(f.hypothesis)) out = with_channel_error(out, f.term, f.values);
  }
  return out;
}

}  // namespace veridyn
