#include "diagnosis/evidence/hypotheses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "diagnosis/evidence/numerics.hpp"
#include "identification/silent_joints.hpp"
#include "veridyn/effects/channel_effect.hpp"

namespace veridyn {
namespace {

// Motion along an axis over all recordings, whose ranges may differ.
AxisMotion motion_along(const Model& arm, const Axis& axis,
                        const std::vector<CompressedRecording>& facts) {
  AxisMotion m;
  m.type = is_prismatic(arm, axis) ? JointType::kPrismatic : JointType::kRevolute;
  m.middle = axis.offset;
  for (const CompressedRecording& r : facts) m.duration = std::max(m.duration, r.facts.duration);
  for (Eigen::Index i = 0; i < axis.coefficients.size(); ++i) {
    const double c = axis.coefficients[i];
    if (c == 0.0 || facts.empty()) continue;
    TorqueFacts all = facts.front().joints[i];
    for (const CompressedRecording& r : facts) {
      const TorqueFacts& joint = r.joints[i];
      all.lowest = std::min(all.lowest, joint.lowest);
      all.highest = std::max(all.highest, joint.highest);
      all.largest_speed = std::max(all.largest_speed, joint.largest_speed);
    }
    m.middle += 0.5 * c * (all.lowest + all.highest);
    m.travel += std::abs(c) * all.travel();
    m.speed += std::abs(c) * all.largest_speed;
  }
  return m;
}

class Builder {
 public:
  Builder(const Model& arm, const std::vector<CompressedRecording>& facts, const CandidateList& list)
      : arm_(arm), facts_(facts), list_(list), description_(arm.description()) {}

  void add_all() {
    for (const auto& [hypothesis, term] : list_.known) {
      Hypothesis h = hypothesis;
      h.part = TermIndex{description_.effects.size()};
      h.columns.clear();
      asked_.insert(key(term));
      description_.effects.push_back(term);
      hypotheses_.push_back(std::move(h));
    }
    Scope scope{list_.wanted, list_.changes, {}};
    const std::set<int> silent = silent_joints(facts_);
    for (int i = 0; i < arm_.joints(); ++i) scope.still.push_back(!moves(i) || silent.count(i) != 0);
    for (const Candidate& candidate : candidates(arm_, scope)) add_candidate(candidate);
  }

  AugmentedModel take() {
    AugmentedModel out{Model(std::move(description_)), std::move(hypotheses_)};
    const std::vector<StandardParameter> parameters = standard_parameters(out.model);
    for (Hypothesis& h : out.hypotheses) h.columns = columns_in(parameters, h);
    return out;
  }

 private:
  // Identifies a term, to the digits that its name shows.
  std::string key(const EffectTerm& term) const {
    std::string out = term.effect + " " + axis_text(arm_, term.axis);
    if (term.from) out += " from " + axis_text(arm_, *term.from);
    for (const auto& [name, value] : term.values) out += fmt::format(" {} {:.4g}", name, value);
    return out;
  }

  bool moves(int joint) const {
    const double still =
        list_.limits.still(arm_.coordinates()[joint].prismatic);
    return std::any_of(facts_.begin(), facts_.end(), [&](const CompressedRecording& r) {
      return r.joints[joint].travel() > still;
    });
  }

  void add_candidate(const Candidate& c) {
    if (is_load(c)) return add_payload(c);
    if (is_channel(c)) return add(c, {});
    if (is_change(c)) return add(c, arm_.effects()[c.own->value].values);
    AxisMotion m = motion_along(arm_, c.axis, facts_);
    if (is_other_constant(c)) return ask_other_constants(c, m);
    const auto joint = static_cast<size_t>(c.joint->value);
    m.waves.emplace();
    if (joint < list_.ripple_orders.size()) m.waves = list_.ripple_orders[joint];
    for (const ShapeChoice& choice : find_effect(effect_of(c.cause)).grid(m)) add(c, choice);
  }

  // Tests another constant of an effect of the arm, for constants with a grid but without a search:
  // values relative to one over the largest speed (the smoothness of a friction step). It is tested
  // beside the causes, because its residual would imitate them.
  void ask_other_constants(const Candidate& c, const AxisMotion& m) {
    if (m.speed <= 0.0) return;
    for (const EffectShape& constant : find_effect(effect_of(c.cause)).shapes()) {
      if (constant.searched || constant.scale != ShapeScale::kByUnit) continue;
      for (const double share : constant.grid) {
        const double value = std::clamp(share / m.speed, constant.lower, constant.upper);
        add(c, {{constant.name, value}});
      }
    }
  }

  void add(const Candidate& c, const ShapeChoice& shape) {
    const Effect& effect = find_effect(effect_of(c.cause));
    EffectTerm term;
    term.effect = effect.name();
    term.axis = c.axis;
    term.values = shape;
    const std::vector<EffectParameter> parameters = effect.parameters();
    const EffectTraits traits = effect.traits();
    const bool slides = is_prismatic(arm_, c.axis);
    for (const EffectParameter& p : parameters) term.values.erase(p.name);
    if (c.from) term.from = Axis{VectorXd::Unit(arm_.joints(), c.from->value), 0.0};
    if (!asked_.insert(key(term)).second) return;
    Hypothesis h(c);
    h.part = TermIndex{description_.effects.size()};
    h.stage = static_cast<int>(traits.stage);
    h.extrapolates = traits.depends_on_position || traits.depends_on_time ||
                     traits.role == EffectRole::kSensor || traits.role == EffectRole::kArm;
    h.repeats = traits.memory;
    for (const EffectShape& constant : effect.shapes()) {
      h.repeats = h.repeats || constant.scale == ShapeScale::kWaves;
      if (constant.scale == ShapeScale::kWaves) h.tried = list_.limits.ripple_finest;
    }
    h.largest_value = numerics::kHuge;
    for (const EffectParameter& p : parameters)
      h.largest_value =
          std::min(h.largest_value, slides ? p.largest_prismatic : p.largest_revolute);
    for (const EffectParameter& p : parameters) {
      h.signs.push_back(is_change(c) ? ParameterSign::kAny : p.sign);
      if (!is_change(c)) continue;
      const auto& own = arm_.effects()[c.own->value].values;
      const auto value = own.find(p.name);
      h.lowest.push_back(p.sign == ParameterSign::kAny || value == own.end() ? -numerics::kHuge
                                                                             : -value->second);
    }
    description_.effects.push_back(std::move(term));
    hypotheses_.push_back(std::move(h));
  }

  // Adds a body on the link, massless until it is fitted.
  void add_payload(const Candidate& c) {
    const FrameIndex on = *frame_of(c.cause);
    Frame load;
    load.name =
        std::string(AddedLoad::kName) + "@" + arm_.frames()[on.value].name;
    load.parent = on;
    load.variable.coefficients = VectorXd::Zero(arm_.joints());
    load.body = Body{};
    load.body->phi = InertialParameters::Zero();
    Hypothesis h(c);
    h.part = BodyIndex{static_cast<int>(arm_.bodies().size()) + payloads_++};
    h.stage = static_cast<int>(DiagnosisStage::kChannel);
    if (description_.box.com_reach > 0.0) h.reach = description_.box.com_reach;
    h.signs.assign(kBodyParameters, ParameterSign::kAny);
    description_.frames.push_back(std::move(load));
    hypotheses_.push_back(std::move(h));
  }

  const Model& arm_;
  const std::vector<CompressedRecording>& facts_;
  const CandidateList& list_;
  int payloads_ = 0;
  std::set<std::string> asked_;
  ModelDescription description_;
  std::vector<Hypothesis> hypotheses_;
};

}  // namespace

const EffectTerm& term_of(const Model& augmented, const Hypothesis& h) {
  return augmented.effects()[std::get<TermIndex>(h.part).value];
}

std::vector<std::string> columns_in(const std::vector<StandardParameter>& all,
                                    const Hypothesis& h) {
  const auto* term = std::get_if<TermIndex>(&h.part);
  const auto* body = std::get_if<BodyIndex>(&h.part);
  std::vector<std::string> out;
  for (const StandardParameter& p : all) {
    const bool own = term != nullptr ? p.effect == static_cast<int>(term->value)
                                     : p.body == body->value;
    if (own) out.push_back(p.name);
  }
  return out;
}

AugmentedModel augmented_model(const Model& arm, const std::vector<CompressedRecording>& facts,
                               const CandidateList& list) {
  Builder builder(arm, facts, list);
  builder.add_all();
  return builder.take();
}

}  // namespace veridyn
