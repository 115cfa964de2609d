#include "diagnosis/causes/hypotheses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "diagnosis/numerics.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/channel_effect.hpp"

namespace veridyn {
namespace {


// Over all recordings together: their ranges may differ.
AxisMotion motion_along(const Model& arm, const Axis& axis,
                        const std::vector<CompressedRecording>& facts) {
  AxisMotion m;
  m.type = is_prismatic(arm, axis) ? JointType::kPrismatic : JointType::kRevolute;
  m.middle = axis.offset;
  for (const CompressedRecording& r : facts) m.duration = std::max(m.duration, r.facts.duration);
  for (Eigen::Index i = 0; i < axis.coefficients.size(); ++i) {
    const double c = axis.coefficients[i];
    if (c == 0.0 || facts.empty()) continue;
    TorqueFacts all = facts.front().joints[static_cast<size_t>(i)];
    for (const CompressedRecording& r : facts) {
      const TorqueFacts& joint = r.joints[static_cast<size_t>(i)];
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

std::optional<TermIndex> own_term(const Model& arm, const std::string& effect, const Axis& axis) {
  for (size_t k = 0; k < arm.effects().size(); ++k) {
    const EffectTerm& term = arm.effects()[k];
    if (term.effect == effect && term.axis.coefficients == axis.coefficients) return TermIndex{k};
  }
  return std::nullopt;
}

// Beside where and with what constants: what a term is to the arm that is asked about.
struct Relation {
  std::optional<JointIndex> from;  // the coordinate that a coupling comes from
  std::optional<TermIndex> own;    // the arm's own effect that it is about
  bool changes = false;            // that one has changed
};

// The frame that a link's frames are fixed to, itself if it moves.
int link_of(const Model& arm, int frame) {
  while (frame >= 0 && arm.frames()[static_cast<size_t>(frame)].type == JointType::kFixed)
    frame = arm.frames()[static_cast<size_t>(frame)].parent;
  return frame;
}

class Builder {
 public:
  Builder(const Model& arm, const std::vector<CompressedRecording>& facts, const QuestionList& list)
      : arm_(arm), facts_(facts), list_(list), description_(arm.description()) {}

  void ask_all() {
    for (const auto& [hypothesis, term] : list_.known) {
      Hypothesis h = hypothesis;
      h.part = TermIndex{description_.effects.size()};
      h.columns.clear();
      asked_.insert(key(term));
      description_.effects.push_back(term);
      hypotheses_.push_back(std::move(h));
    }
    // Friction holds a joint at rest against anything: its torque says nothing about the arm.
    int moving = 0;
    for (int i = 0; i < arm_.joints(); ++i) moving += static_cast<int>(moves(i));
    const bool whole_arm = 2 * moving >= arm_.joints();
    for (const ChannelEffect* channel : channel_effects()) {
      const bool of_arm = channel->whole_arm() || channel->can_be_common();
      const bool asked = channel->asked_unnamed() || !list_.wanted.empty();
      if (whole_arm && of_arm && asked && wanted(channel->name()))
        add(*channel, {VectorXd::Zero(arm_.joints()), 0.0}, {});
    }
    for (const Axis& axis : axes()) {
      const AxisMotion m = motion_along(arm_, axis, facts_);
      if (!moves(main_coordinate(axis))) continue;
      for (const AxisEffect* effect : axis_effects()) ask(*effect, axis, m);
      const bool plain = (axis.coefficients.array() != 0.0).count() == 1;
      for (const ChannelEffect* channel : channel_effects()) {
        if (plain && !channel->whole_arm() && wanted(channel->name())) add(*channel, axis, {});
      }
    }
    if (whole_arm && list_.changes && wanted(AddedLoad::kName)) {
      for (const int frame : payload_frames(arm_)) add_payload(frame);
    }
  }

  AugmentedModel take() {
    AugmentedModel out{Model(std::move(description_)), std::move(hypotheses_)};
    const std::vector<StandardParameter> parameters = standard_parameters(out.model);
    for (Hypothesis& h : out.hypotheses) h.columns = columns_in(parameters, h);
    return out;
  }

 private:
  // Every coordinate, and every other axis on which the model has friction already.
  std::vector<Axis> axes() const {
    std::vector<Axis> out;
    for (int i = 0; i < arm_.joints(); ++i) out.push_back({VectorXd::Unit(arm_.joints(), i), 0.0});
    for (const EffectTerm& term : arm_.effects()) {
      const bool known = std::any_of(out.begin(), out.end(), [&term](const Axis& a) {
        return (a.coefficients - term.axis.coefficients).norm() < numerics::kSameAxis ||
               std::abs(a.coefficients.normalized().dot(term.axis.coefficients.normalized())) >
                   1.0 - numerics::kSameAxis;
      });
      if (!known && find_effect(term.effect).traits().role == EffectRole::kFriction)
        out.push_back(term.axis);
    }
    // Joint variables that are mixtures of coordinates.
    for (const Frame& frame : arm_.frames()) {
      const VectorXd& c = frame.variable.coefficients;
      if (frame.type == JointType::kFixed || c.isZero(0.0)) continue;
      const bool known = std::any_of(out.begin(), out.end(), [&c](const Axis& a) {
        return std::abs(a.coefficients.normalized().dot(c.normalized())) > 1.0 - numerics::kSameAxis;
      });
      if (!known && (c.array() != 0.0).count() > 1) out.push_back({c, 0.0});
    }
    return out;
  }

  // What tells one term from another, to as many digits as its name shows.
  std::string key(const EffectTerm& term) const {
    std::string out = term.effect + " " + axis_text(arm_, term.axis);
    if (term.from) out += " from " + axis_text(arm_, *term.from);
    for (const auto& [name, value] : term.values) out += fmt::format(" {} {:.4g}", name, value);
    return out;
  }

  bool moves(int joint) const {
    const double still =
        list_.limits.still(arm_.coordinates()[static_cast<size_t>(joint)].prismatic);
    return std::any_of(facts_.begin(), facts_.end(), [&](const CompressedRecording& r) {
      return r.joints[static_cast<size_t>(joint)].travel() > still;
    });
  }

  bool wanted(const std::string& name) const {
    const std::vector<std::string>& some = list_.wanted;
    return some.empty() || std::find(some.begin(), some.end(), name) != some.end();
  }

  void ask(const AxisEffect& effect, const Axis& axis, AxisMotion m) {
    if (!wanted(effect.name())) return;
    const EffectTraits traits = effect.traits();
    const bool plain = (axis.coefficients.array() != 0.0).count() == 1;
    if (!plain && !traits.mixed_axes) return;
    const std::optional<TermIndex> own = own_term(arm_, effect.name(), axis);
    if (own && list_.changes && !traits.uses_source) {
      add(effect, axis, arm_.effects()[own->value].values, {std::nullopt, own, true});
      if (effect.shapes().empty()) return;
    }
    if (own && !list_.changes) ask_other_constants(effect, axis, m, *own);
    if (own && !list_.changes && !traits.memory) return;
    const auto joint = static_cast<size_t>(main_coordinate(axis));
    m.waves.emplace();
    if (joint < list_.ripple_orders.size()) m.waves = list_.ripple_orders[joint];
    for (const ShapeChoice& choice : effect.grid(m)) {
      if (!traits.uses_source) add(effect, axis, choice);
      for (int from = 0; traits.uses_source && from < arm_.joints(); ++from) {
        if (axis.coefficients[from] == 0.0) add(effect, axis, choice, {JointIndex{from}, std::nullopt, false});
      }
    }
  }

  // A constant that no search looks for, yet has a grid: an effect that the arm has may have
  // another one than its file says, in shares of one over the largest speed (a step of friction that
  // is smooth). It is asked beside the causes, for what it leaves over looks like them.
  void ask_other_constants(const AxisEffect& effect, const Axis& axis, const AxisMotion& m,
                           TermIndex own) {
    if (m.speed <= 0.0) return;
    for (const EffectShape& constant : effect.shapes()) {
      if (constant.searched || constant.scale != ShapeScale::kByUnit) continue;
      for (const double share : constant.grid) {
        const double value = std::clamp(share / m.speed, constant.lower, constant.upper);
        add(effect, axis, {{constant.name, value}}, {std::nullopt, own, false});
      }
    }
  }

  static Cause cause_of(const Effect& effect, const Axis& axis, bool changes) {
    const std::string name = effect.name();
    if (axis.coefficients.isZero(0.0)) return ChannelError{name, std::nullopt};
    const JointIndex joint{main_coordinate(axis)};
    if (channel_effect(name) != nullptr) return ChannelError{name, joint};
    if (changes) return ChangedEffect{name, joint};
    return NewEffect{name, joint};
  }

  void add(const Effect& effect, const Axis& axis, const ShapeChoice& shape,
           const Relation& relation = {}) {
    EffectTerm term;
    term.effect = effect.name();
    term.axis = axis;
    term.values = shape;
    const std::vector<EffectParameter> parameters = effect.parameters();
    const EffectTraits traits = effect.traits();
    const bool slides = is_prismatic(arm_, axis);
    for (const EffectParameter& p : parameters) term.values.erase(p.name);
    if (relation.from)
      term.from = Axis{VectorXd::Unit(arm_.joints(), relation.from->value), 0.0};
    if (!asked_.insert(key(term)).second) return;
    Hypothesis h;
    h.cause = cause_of(effect, axis, relation.changes);
    h.joint = joint_of(h.cause);
    h.own = relation.own;
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
    h.family = relation.changes ? "changed " : relation.own ? "own " : "";
    h.family += term.effect + " " + axis_text(arm_, axis);
    if (relation.from)
      h.family += " from " + arm_.coordinates()[static_cast<size_t>(relation.from->value)].name;
    for (const EffectParameter& p : parameters)
      h.signs.push_back(relation.changes ? ParameterSign::kAny : p.sign);
    for (const EffectParameter& p : parameters) {
      if (!relation.changes) break;
      const auto& own = arm_.effects()[relation.own->value].values;
      const auto value = own.find(p.name);
      h.lowest.push_back(p.sign == ParameterSign::kAny || value == own.end() ? -numerics::kHuge
                                                                             : -value->second);
    }
    description_.effects.push_back(std::move(term));
    hypotheses_.push_back(std::move(h));
  }

  // One body more on the link, without mass as long as nobody fits it.
  void add_payload(int frame) {
    Frame load;
    load.name =
        std::string(AddedLoad::kName) + "@" + arm_.frames()[static_cast<size_t>(frame)].name;
    load.parent = frame;
    load.variable.coefficients = VectorXd::Zero(arm_.joints());
    load.body = Body{};
    load.body->phi = InertialParameters::Zero();
    Hypothesis h;
    h.cause = AddedLoad{{frame}};
    h.joint = acting_joint(arm_, h.cause);
    h.part = BodyIndex{static_cast<int>(arm_.bodies().size()) + payloads_++};
    h.stage = static_cast<int>(DiagnosisStage::kChannel);
    if (description_.box.com_reach > 0.0) h.reach = description_.box.com_reach;
    h.family = load.name;
    h.signs.assign(kBodyParameters, ParameterSign::kAny);
    description_.frames.push_back(std::move(load));
    hypotheses_.push_back(std::move(h));
  }

  const Model& arm_;
  const std::vector<CompressedRecording>& facts_;
  const QuestionList& list_;
  int payloads_ = 0;
  std::set<std::string> asked_;
  ModelDescription description_;
  std::vector<Hypothesis> hypotheses_;
};

}  // namespace

bool is_load(const Hypothesis& h) {
  return std::holds_alternative<BodyIndex>(h.part);
}

bool is_change(const Hypothesis& h) {
  return std::holds_alternative<ChangedEffect>(h.cause);
}

bool is_other_constant(const Hypothesis& h) {
  return h.own && !is_change(h);
}

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

std::vector<std::string> elementary_effects() {
  std::vector<const AxisEffect*> found;
  for (const AxisEffect* effect : axis_effects()) {
    if (effect->traits().elementary) found.push_back(effect);
  }
  const auto rank = [](const AxisEffect* effect) {
    const EffectTraits traits = effect->traits();
    return std::make_pair(traits.stage, traits.dry == DryFriction::kNone);
  };
  std::stable_sort(found.begin(), found.end(),
                   [&rank](const AxisEffect* a, const AxisEffect* b) { return rank(a) < rank(b); });
  std::vector<std::string> out;
  for (const AxisEffect* effect : found) out.push_back(effect->name());
  return out;
}

std::vector<int> payload_frames(const Model& arm) {
  std::vector<int> out;
  for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
    const int link = link_of(arm, k);
    if (link < 0) continue;
    const auto same =
        std::find_if(out.begin(), out.end(), [&](int other) { return same_link(arm, other, k); });
    if (same == out.end()) {
      out.push_back(k);
    } else {
      *same = k;
    }
  }
  return out;
}

bool same_link(const Model& arm, int a, int b) {
  return link_of(arm, a) == link_of(arm, b);
}

AugmentedModel augmented_model(const Model& arm, const std::vector<CompressedRecording>& facts,
                               const QuestionList& list) {
  Builder builder(arm, facts, list);
  builder.ask_all();
  return builder.take();
}

}  // namespace veridyn
