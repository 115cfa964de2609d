#include "diagnosis/candidates.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/moving_frame.hpp"
#include "veridyn/effects/channel_effect.hpp"

namespace veridyn {
namespace {

constexpr double kSameDirection = 1e-9;  // 1 - cosine, below which two axes are the same

bool is_single_coordinate(const Axis& axis) {
  return (axis.coefficients.array() != 0.0).count() == 1;
}

bool are_parallel(const VectorXd& a, const VectorXd& b) {
  return std::abs(a.normalized().dot(b.normalized())) > 1.0 - kSameDirection;
}

// Axes to test: every coordinate, every other axis with friction in the model, and every joint variable that
// is a mixture of coordinates.
std::vector<Axis> axes_of(const Model& arm) {
  std::vector<Axis> out;
  const auto add = [&out](const Axis& axis) {
    if (std::none_of(out.begin(), out.end(), [&axis](const Axis& a) {
          return are_parallel(a.coefficients, axis.coefficients);
        }))
      out.push_back(axis);
  };
  for (int i = 0; i < arm.joints(); ++i) out.push_back({VectorXd::Unit(arm.joints(), i), 0.0});
  for (const EffectTerm& term : arm.effects()) {
    if (is_friction(term.effect)) add(term.axis);
  }
  for (const Frame& frame : arm.frames()) {
    const Axis axis{frame.variable.coefficients, 0.0};
    if (frame.type != JointType::kFixed && !axis.coefficients.isZero(0.0) && !is_single_coordinate(axis)) add(axis);
  }
  return out;
}

// Index of the arm's own effect of this kind along exactly this axis, if it has one.
std::optional<TermIndex> own_effect_index(const Model& arm, const std::string& effect, const Axis& axis) {
  for (size_t k = 0; k < arm.effects().size(); ++k) {
    const EffectTerm& term = arm.effects()[k];
    if (term.effect == effect && term.axis.coefficients == axis.coefficients) return TermIndex{k};
  }
  return std::nullopt;
}

Candidate channel_candidate(const Model& arm, const ChannelEffect& channel, std::optional<JointIndex> joint,
                     std::optional<JointIndex> from = {}) {
  VectorXd axis = VectorXd::Zero(arm.joints());
  if (joint) axis[joint->value] = 1.0;
  return {ChannelError{channel.name(), joint}, joint, {std::move(axis), 0.0}, from};
}

Candidate load_candidate(const Model& arm, FrameIndex frame) {
  const Cause cause = AddedLoad{frame};
  return {cause, acting_joint(arm, cause), {VectorXd::Zero(arm.joints()), 0.0}, std::nullopt};
}

class Enumeration {
 public:
  Enumeration(const Model& arm, const Scope& scope) : arm_(arm), scope_(scope) {}

  std::vector<Candidate> all() {
    const long still = std::count(scope_.still.begin(), scope_.still.end(), true);
    const bool whole_arm = 2 * (arm_.joints() - still) >= arm_.joints();
    for (const ChannelEffect* channel : channel_effects()) {
      const bool of_arm = channel->whole_arm() || channel->can_be_common();
      if (whole_arm && of_arm && is_testable(*channel))
        out_.push_back(channel_candidate(arm_, *channel, std::nullopt));
    }
    for (const Axis& axis : axes_of(arm_)) {
      const JointIndex joint = main_coordinate(axis);
      if (static_cast<size_t>(joint.value) < scope_.still.size() &&
          scope_.still[joint.value])
        continue;
      for (const AxisEffect* effect : axis_effects()) add(*effect, axis, joint);
      for (const ChannelEffect* channel : channel_effects()) {
        if (is_single_coordinate(axis) && !channel->whole_arm() && is_testable(*channel)) add(*channel, joint);
      }
    }
    if (whole_arm && scope_.changes && is_wanted(AddedLoad::kName)) {
      for (const FrameIndex frame : payload_frames(arm_)) out_.push_back(load_candidate(arm_, frame));
    }
    return std::move(out_);
  }

 private:
  bool is_wanted(const std::string& name) const {
    const std::vector<std::string>& some = scope_.wanted;
    return some.empty() || std::find(some.begin(), some.end(), name) != some.end();
  }

  // An arm error with more parameters than joints could imitate nearly any function of the positions.
  bool is_testable(const ChannelEffect& channel) const {
    return is_wanted(channel.name()) && (!scope_.wanted.empty() || static_cast<int>(channel.parameters().size()) <= arm_.joints());
  }

  void add(const ChannelEffect& channel, JointIndex joint) {
    if (!channel.traits().uses_source) {
      out_.push_back(channel_candidate(arm_, channel, joint));
      return;
    }
    for (int from = 0; from < arm_.joints(); ++from) {
      const bool still = static_cast<size_t>(from) < scope_.still.size() && scope_.still[from];
      if (from != joint.value && !still) out_.push_back(channel_candidate(arm_, channel, joint, JointIndex{from}));
    }
  }

  // Adds the effect, and the change of an effect that the arm has already (or another constant of it). A
  // second effect of one kind is a cause if several can act together (memories), or if the values of the
  // first are facts.
  void add(const AxisEffect& effect, const Axis& axis, JointIndex joint) {
    const EffectTraits traits = effect.traits();
    if (!is_wanted(effect.name()) || (!is_single_coordinate(axis) && !traits.mixed_axes)) return;
    const std::optional<TermIndex> own = own_effect_index(arm_, effect.name(), axis);
    const bool changes = own && scope_.changes && !traits.uses_source;
    if (changes) out_.push_back({ChangedEffect{effect.name(), joint}, joint, axis, std::nullopt, own});
    if (changes && effect.shapes().empty()) return;
    const Cause cause = NewEffect{effect.name(), joint};
    if (own && !scope_.changes) {
      out_.push_back({cause, joint, axis, std::nullopt, own});
      if (!traits.memory) return;
    }
    if (!traits.uses_source) {
      out_.push_back({cause, joint, axis, std::nullopt});
      return;
    }
    for (int from = 0; from < arm_.joints(); ++from) {
      if (axis.coefficients[from] == 0.0) out_.push_back({cause, joint, axis, JointIndex{from}});
    }
  }

  const Model& arm_;
  const Scope& scope_;
  std::vector<Candidate> out_;
};

}  // namespace

bool is_load(const Candidate& c) {
  return std::holds_alternative<AddedLoad>(c.cause);
}

bool is_changed_effect(const Candidate& c) {
  return std::holds_alternative<ChangedEffect>(c.cause);
}

bool is_changed_constant(const Candidate& c) {
  return c.own && !is_changed_effect(c);
}

bool is_channel(const Candidate& c) {
  return std::holds_alternative<ChannelError>(c.cause);
}

std::vector<Candidate> candidates(const Model& arm, const Scope& scope) {
  return Enumeration(arm, scope).all();
}

std::vector<Candidate> sudden_candidates(const Model& arm, const std::vector<FrameIndex>& loads) {
  std::vector<Candidate> out;
  const int n = arm.joints();
  for (const AxisEffect* effect : axis_effects()) {
    for (int j = 0; j < n && effect->traits().elementary; ++j)
      out.push_back({NewEffect{effect->name(), {j}}, JointIndex{j}, {VectorXd::Unit(n, j), 0.0}, std::nullopt});
  }
  for (const ChannelEffect* channel : channel_effects()) {
    const auto* sensor = dynamic_cast<const SensorError*>(channel);
    if (sensor == nullptr || !sensor->may_begin_suddenly()) continue;
    if (sensor->can_be_common() && n > 1) out.push_back(channel_candidate(arm, *sensor, std::nullopt));
    for (int j = 0; j < n; ++j) out.push_back(channel_candidate(arm, *sensor, JointIndex{j}));
  }
  for (const FrameIndex frame : loads) out.push_back(load_candidate(arm, frame));
  return out;
}

bool is_friction(const std::string& effect) {
  return has_effect(effect) && find_effect(effect).traits().role == EffectRole::kFriction;
}

std::vector<FrameIndex> payload_frames(const Model& arm) {
  std::vector<FrameIndex> out;
  for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
    if (!moving_frame(arm, FrameIndex{k})) continue;
    const auto same = std::find_if(out.begin(), out.end(),
                                   [&](FrameIndex other) { return same_link(arm, other, {k}); });
    if (same == out.end()) {
      out.push_back({k});
    } else {
      *same = {k};
    }
  }
  return out;
}

bool same_link(const Model& arm, FrameIndex a, FrameIndex b) {
  return moving_frame(arm, a) == moving_frame(arm, b);
}

}  // namespace veridyn
