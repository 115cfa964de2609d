#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <variant>

#include "regressor/arm_columns.hpp"
#include "excitation/search/column_choice.hpp"
#include "regressor/random_states.hpp"
#include "veridyn/identification/base_parameters.hpp"
#include "excitation/search/question.hpp"
#include "kinematics/motion_limits.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/effects/effect_facts.hpp"

namespace veridyn {
namespace {

// One of the two causes, with its text for messages.
struct KnownRival {
  std::string label;
  Cause cause;
};

VectorXd own_values(const Model& arm, const KnownRival& rival) {
  const auto phi = arm.inertial_values();
  require(phi.has_value(), "excitation: '", rival.label, "' follows from the arm's values, but '",
          arm.name(), "' has bodies without mass, com and inertia.");
  return *phi;
}

using Columns = std::vector<std::shared_ptr<const ColumnSource>>;

// The columns of a body on this frame.
Columns body_on_frame(const Model& arm, FrameIndex frame, const std::vector<int>& kept) {
  ModelDescription only = arm.description();
  for (Frame& f : only.frames) f.body.reset();
  only.frames[frame.value].body = Body{};
  only.effects.clear();
  return {some_columns(body_columns(Model(std::move(only))), kept)};
}

Columns channel_columns(const Model& arm, const KnownRival& rival, const ChannelError& cause) {
  const ChannelEffect& channel = *channel_effect(cause.effect);
  require(channel.has_rigid_columns(), "excitation: '", rival.label,
          "' has no column that the motion of joints could be planned for.");
  const VectorXd phi = own_values(arm, rival);
  Columns out;
  for (const RigidColumn& column : channel.rigid_columns(arm, cause.joint)) {
    ModelDescription d = arm.description();
    d.gravity = column.gravity;
    out.push_back(torque_column(Model(std::move(d)), phi,
                                column.at_rest ? TorquePart::kGravityOnly : TorquePart::kWhole,
                                column.joints));
  }
  require(!out.empty(), "excitation: '", rival.label, "' does nothing to this arm.");
  return out;
}

bool is_effect_on_joint(const EffectTerm& term, const std::string& effect, JointIndex joint) {
  return term.effect == effect &&
         term.axis.coefficients == VectorXd::Unit(term.axis.coefficients.size(), joint.value);
}

constexpr size_t kMostChoices = 3;  // largest number of choices of one cause's constants

// Every second choice, as long as there are too many: neighbours on a fine grid have nearly the same columns.
std::vector<ShapeChoice> thinned(std::vector<ShapeChoice> choices) {
  while (choices.size() > kMostChoices) {
    std::vector<ShapeChoice> fewer;
    for (size_t k = 1; k < choices.size(); k += 2) fewer.push_back(choices[k]);
    choices = std::move(fewer);
  }
  return choices;
}

AxisMotion motion_range_of(const Model& arm, JointIndex joint) {
  const MotionLimits limits = motion_limits(arm);
  AxisMotion m;
  const int i = joint.value;
  if (arm.coordinates()[i].prismatic) m.type = JointType::kPrismatic;
  m.middle = 0.5 * (limits.lower[i] + limits.upper[i]);
  m.travel = limits.upper[i] - limits.lower[i];
  m.speed = limits.velocity[i];
  return m;
}

// The effect with the constants that the model has on this axis. If it has none, one term for each of a few
// choices, because a diagnosis may find any of them.
std::vector<EffectTerm> effect_terms(const Model& arm, const std::string& effect,
                                     JointIndex joint) {
  for (const EffectTerm& own : arm.effects()) {
    if (is_effect_on_joint(own, effect, joint)) return {own};
  }
  EffectTerm term;
  term.effect = effect;
  term.axis.coefficients = VectorXd::Unit(arm.joints(), joint.value);
  std::vector<EffectTerm> out;
  for (const ShapeChoice& choice : thinned(find_effect(effect).grid(motion_range_of(arm, joint)))) {
    term.values = choice;
    for (const EffectShape& shape : find_effect(effect).shapes()) {
      const auto value = term.values.find(shape.name);
      if (shape.searched && value != term.values.end())
        value->second = std::clamp(value->second, shape.lower, shape.upper);
    }
    out.push_back(term);
  }
  return out;
}

std::vector<int> numbers(int first, int count) {
  std::vector<int> out(count);
  std::iota(out.begin(), out.end(), first);
  return out;
}

// Relative sizes of the parameters: 1 kg within 0.1 m for a load, otherwise equal torques.
VectorXd sizes_of(const KnownRival& rival, const MatrixXd& W, const std::vector<int>& columns,
                  int first) {
  VectorXd out(columns.size());
  for (size_t k = 0; k < columns.size(); ++k) {
    const int parameter = columns[k] - first;
    const double of_load = parameter == 0 ? 1.0 : parameter < 4 ? 0.1 : 0.01;
    const double of_effect = columns.size() == 1 ? 1.0 : 1.0 / W.col(columns[k]).norm();
    const bool load = std::holds_alternative<AddedLoad>(rival.cause);
    out[static_cast<Eigen::Index>(k)] = load ? of_load : of_effect;
  }
  return out;
}

Columns axis_columns(const Model& arm, const KnownRival& rival, const NewEffect& cause,
                     double rounding) {
  const EffectTraits traits = find_effect(cause.effect).traits();
  if (traits.uses_load) own_values(arm, rival);
  require(!traits.uses_source, "excitation: '", rival.label,
          "' needs another joint and cannot be a rival yet.");
  Columns out;
  for (const EffectTerm& term : effect_terms(arm, cause.effect, cause.joint))
    out.push_back(effect_columns(arm, term, rounding * motion_limits(arm).velocity));
  return out;
}

Columns rival_columns(const Model& arm, const KnownRival& rival, double rounding) {
  if (const auto* load = std::get_if<AddedLoad>(&rival.cause))
    return body_on_frame(arm, load->frame, numbers(0, kBodyParameters));
  if (const auto* inertia = std::get_if<AddedInertia>(&rival.cause))
    return body_on_frame(arm, inertia->frame, {4, 6, 9});
  if (const auto* channel = std::get_if<ChannelError>(&rival.cause))
    return channel_columns(arm, rival, *channel);
  const auto* effect = std::get_if<NewEffect>(&rival.cause);
  require(effect != nullptr, "excitation: '", rival.label,
          "': found a cause that no motion can be planned for, expected a load, a channel error or "
          "an effect that acts along an axis.");
  return axis_columns(arm, rival, *effect, rounding);
}

// Removes terms of the two causes from the model: the question is then how they have changed.
Model without_rivals(const Model& arm, const std::array<KnownRival, 2>& rivals) {
  ModelDescription rest = arm.description();
  const auto is_rival = [&](const EffectTerm& term) {
    if (!EffectFacts(arm, term).has_values()) return false;
    return std::any_of(rivals.begin(), rivals.end(), [&term](const KnownRival& rival) {
      const auto* effect = std::get_if<NewEffect>(&rival.cause);
      return effect != nullptr && is_effect_on_joint(term, effect->effect, effect->joint);
    });
  };
  rest.effects.erase(std::remove_if(rest.effects.begin(), rest.effects.end(), is_rival),
                     rest.effects.end());
  return Model(std::move(rest));
}

// The columns of a discrimination: those of the arm, then A's, then B's.
struct Choice {
  std::vector<int> nuisance, first, second;
};

// Selects nuisance columns among `candidates`, and the independent columns of each cause.
Choice choose(const MatrixXd& W, const std::vector<int>& candidates, const std::vector<int>& a,
              const std::vector<int>& b) {
  Choice out;
  out.nuisance = independent_columns(W, candidates);
  out.first = independent_columns(W, a, out.nuisance);
  out.second = independent_columns(W, b, out.nuisance);
  return out;
}

}  // namespace

void add_rivals(const Model& arm, const ExcitationOptions& options, double rounding,
                Question& question) {
  const Model& known = options.powered ? *options.powered : arm;
  const KnownRival a = {to_text(known, options.between->first), options.between->first};
  const KnownRival b = {to_text(known, options.between->second), options.between->second};
  question.rival_names = {a.label, b.label};
  const Model others = without_rivals(known, {a, b});
  int body_count = 0;
  int arm_count = 0;
  int first_count = 0;
  const auto stack = [&](double round) {
    auto sources = arm_columns(others, round);
    body_count = sources.front()->count();
    arm_count = 0;
    for (const auto& source : sources) arm_count += source->count();
    const auto first = rival_columns(known, a, round);
    const auto second = rival_columns(known, b, round);
    first_count = 0;
    for (const auto& source : first) first_count += source->count();
    sources.insert(sources.end(), first.begin(), first.end());
    sources.insert(sources.end(), second.begin(), second.end());
    return std::make_shared<StackedColumns>(known.joints(), sources);
  };
  const auto exact = stack(0.0);
  const auto rounded = stack(rounding);
  const int states = 40 + 2 * exact->count() / std::max(1, known.joints());
  const MatrixXd W = exact->stacked(random_states(known, states));
  const std::vector<int> of_a = numbers(arm_count, first_count);
  const std::vector<int> of_b =
      numbers(arm_count + first_count, exact->count() - arm_count - first_count);
  Choice choice = choose(W, preferred_columns(standard_parameters(others)), of_a, of_b);
  if (choice.first.empty() || choice.second.empty()) {
    // Parameters of the bodies can imitate the cause, which is identifiable only if the bodies are known.
    question.bodies_known = true;
    choice = choose(W, numbers(body_count, arm_count - body_count), of_a, of_b);
  }
  for (const auto& [rival, columns] : {std::make_pair(a, choice.first), {b, choice.second}}) {
    require(!columns.empty(), "excitation: '", rival.label,
            "' cannot be told from what the model has already, whatever the motion.");
  }
  const auto beyond = [&](const std::vector<int>& own, const std::vector<int>& other) {
    std::vector<int> rest = choice.nuisance;
    rest.insert(rest.end(), other.begin(), other.end());
    return !independent_columns(W, own, rest).empty();
  };
  const bool first_shows = beyond(choice.first, choice.second);
  const bool second_shows = beyond(choice.second, choice.first);
  require(first_shows || second_shows, "excitation: '", a.label, "' and '", b.label,
          "' cannot be told apart, whatever the motion: they have the same columns.");
  std::vector<int> taken = choice.nuisance;
  taken.insert(taken.end(), choice.first.begin(), choice.first.end());
  taken.insert(taken.end(), choice.second.begin(), choice.second.end());
  for (const KnownRival& rival : {a, b}) {
    if (const auto joint = joint_of(rival.cause)) question.rival_joints.push_back(joint->value);
  }
  exact->choose(taken);
  rounded->choose(taken);
  question.exact = exact;
  question.rounded = rounded;
  question.rivals = {
      static_cast<int>(choice.nuisance.size()),
      (first_shows ? 1.0 : 0.0) * sizes_of(a, W, choice.first, arm_count),
      (second_shows ? 1.0 : 0.0) * sizes_of(b, W, choice.second, arm_count + first_count)};
  question.scale = W(Eigen::all, taken).colwise().norm().transpose() / std::sqrt(states);
}

}  // namespace veridyn
