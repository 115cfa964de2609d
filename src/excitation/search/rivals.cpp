#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "excitation/columns/arm_columns.hpp"
#include "excitation/search/question.hpp"
#include "veridyn/kinematics/motion_limits.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"

namespace veridyn {
namespace {

std::string label(const RivalCause& rival) {
  return rival.place.empty() ? rival.effect : rival.effect + ":" + rival.place;
}

int find_joint(const Model& arm, const RivalCause& rival) {
  std::vector<std::string> names;
  for (const Coordinate& c : arm.coordinates()) names.push_back(c.name);
  int joint = arm.find_coordinate(rival.place);
  const bool number = !rival.place.empty() && rival.place.size() < 4 &&
                      rival.place.find_first_not_of("0123456789") == std::string::npos;
  if (joint < 0 && number) joint = std::stoi(rival.place) - 1;
  require(joint >= 0 && joint < arm.joints(), "excitation: '", label(rival), "': found the joint '",
          rival.place, "'", did_you_mean(rival.place, names), ", expected a number from 1 to ",
          arm.joints(), " or one of: ", listed(names), ".");
  return joint;
}

VectorXd own_values(const Model& arm, const RivalCause& rival) {
  const auto phi = arm.inertial_values();
  require(phi.has_value(), "excitation: '", label(rival), "' follows from the arm's values, but '",
          arm.name(), "' has bodies without mass, com and inertia.");
  return *phi;
}

// One body on the frame and no other.
std::unique_ptr<ColumnSource> body_on_frame(const Model& arm, const RivalCause& rival,
                                            const std::vector<int>& kept) {
  std::vector<std::string> names;
  for (const Frame& frame : arm.frames()) names.push_back(frame.name);
  const int k = arm.find_frame(rival.place);
  require(k >= 0, "excitation: '", label(rival), "': found the frame '", rival.place, "'",
          did_you_mean(rival.place, names), ", expected one of: ", listed(names), ".");
  ModelDescription only = arm.description();
  for (Frame& frame : only.frames) frame.body.reset();
  only.frames[static_cast<size_t>(k)].body = Body{};
  only.effects.clear();
  return some_columns(body_columns(Model(std::move(only))), kept);
}

std::vector<std::shared_ptr<const ColumnSource>> tilt_columns(const Model& arm,
                                                              const RivalCause& rival) {
  const VectorXd phi = own_values(arm, rival);
  const Eigen::Vector3d g = arm.gravity();
  require(g.norm() > 0.0, "excitation: '", label(rival), "': the arm has no gravity.");
  const Eigen::Vector3d across = g.unitOrthogonal();
  std::vector<std::shared_ptr<const ColumnSource>> out;
  for (const Eigen::Vector3d& axis : {across, Eigen::Vector3d(g.normalized().cross(across))}) {
    ModelDescription tilted = arm.description();
    tilted.gravity = axis.cross(g);  // per radian
    out.push_back(torque_column(Model(std::move(tilted)), phi, TorquePart::kGravityOnly,
                                VectorXd::Ones(arm.joints())));
  }
  return out;
}

bool is_on(const EffectTerm& term, const RivalCause& rival, const Model& arm, int joint) {
  return term.effect == rival.effect &&
         term.axis.coefficients == VectorXd::Unit(arm.joints(), joint);
}

// Lengths and speeds that a rival's constant may have, as shares of the joint's range and speed.
constexpr std::array<double, 3> kLengthShares = {1e-3, 1e-2, 0.1};
constexpr std::array<double, 3> kSpeedShares = {0.02, 0.06, 0.2};

// The effect with the constants that the model found for it there. Without any, one term for each
// of several lengths or speeds: a diagnosis may choose whichever suits it best.
std::vector<EffectTerm> effect_terms(const Model& arm, const RivalCause& rival, int joint) {
  EffectTerm term;
  term.effect = rival.effect;
  term.axis.coefficients = VectorXd::Unit(arm.joints(), joint);
  for (const EffectTerm& own : arm.effects()) {
    if (is_on(own, rival, arm, joint)) return {own};
  }
  const MotionLimits limits = motion_limits(arm);
  const double range = limits.upper[joint] - limits.lower[joint];
  std::vector<EffectTerm> out{term};
  for (const EffectShape& shape : find_effect(rival.effect).shapes()) {
    // Ranges that an effect wants to know are the joint's.
    const auto set = [&](double value) {
      for (EffectTerm& one : out) one.values[shape.name] = value;
    };
    if (shape.name == "centre") set(0.5 * (limits.lower[joint] + limits.upper[joint]));
    if (shape.name == "half_range") set(0.5 * range);
    const bool speed = shape.unit_revolute == "rad/s";
    if (!shape.searched || !shape.logarithmic || (!speed && shape.unit_revolute != "rad")) continue;
    std::vector<EffectTerm> family;
    for (const double share : speed ? kSpeedShares : kLengthShares) {
      const double value = share * (speed ? limits.velocity[joint] : range);
      set(std::clamp(value, shape.lower, shape.upper));
      family.insert(family.end(), out.begin(), out.end());
    }
    out = std::move(family);
  }
  return out;
}

std::vector<int> numbers(int first, int count) {
  std::vector<int> out(static_cast<size_t>(count));
  std::iota(out.begin(), out.end(), first);
  return out;
}

// How large the parameters are beside each other: 1 kg within 0.1 m, or equal torques.
VectorXd sizes_of(const RivalCause& rival, const MatrixXd& W, const std::vector<int>& columns,
                  int first) {
  VectorXd out(static_cast<Eigen::Index>(columns.size()));
  for (size_t k = 0; k < columns.size(); ++k) {
    const int parameter = columns[k] - first;
    const double of_load = parameter == 0 ? 1.0 : parameter < 4 ? 0.1 : 0.01;
    const double of_effect = columns.size() == 1 ? 1.0 : 1.0 / W.col(columns[k]).norm();
    out[static_cast<Eigen::Index>(k)] = rival.effect == "payload" ? of_load : of_effect;
  }
  return out;
}

std::vector<std::shared_ptr<const ColumnSource>> rival_columns(const Model& arm,
                                                               const RivalCause& rival,
                                                               double rounding) {
  if (rival.effect == "payload") return {body_on_frame(arm, rival, numbers(0, kBodyParameters))};
  if (rival.effect == "inertia") return {body_on_frame(arm, rival, {4, 6, 9})};
  if (rival.effect == "gravity_tilt") return tilt_columns(arm, rival);
  if (rival.effect == "torque_gain") {
    const VectorXd joint = VectorXd::Unit(arm.joints(), find_joint(arm, rival));
    return {torque_column(arm, own_values(arm, rival), TorquePart::kWhole, joint)};
  }
  require(has_effect(rival.effect), "excitation: '", label(rival), "': found '", rival.effect,
          "', expected payload, inertia, gravity_tilt, torque_gain or an effect that acts along an "
          "axis.");
  const int joint = find_joint(arm, rival);
  if (find_effect(rival.effect).needs_load()) own_values(arm, rival);
  require(!find_effect(rival.effect).needs_source(), "excitation: '", label(rival),
          "' needs another joint and cannot be a rival yet.");
  std::vector<std::shared_ptr<const ColumnSource>> out;
  for (const EffectTerm& term : effect_terms(arm, rival, joint))
    out.push_back(effect_columns(arm, term, rounding * motion_limits(arm).velocity));
  return out;
}

// Without the rivals' own terms where they have values: what changed of them is asked then.
Model without_rivals(const Model& arm, const std::pair<RivalCause, RivalCause>& rivals) {
  ModelDescription rest = arm.description();
  const auto is_rival = [&](const EffectTerm& term) {
    if (!BoundEffect(arm, term).has_values()) return false;
    for (const RivalCause& rival : {rivals.first, rivals.second}) {
      if (rival.effect == term.effect && is_on(term, rival, arm, find_joint(arm, rival)))
        return true;
    }
    return false;
  };
  rest.effects.erase(std::remove_if(rest.effects.begin(), rest.effects.end(), is_rival),
                     rest.effects.end());
  return Model(std::move(rest));
}

// The columns of a discrimination: first those of the arm, then A's, then B's.
struct Choice {
  std::vector<int> nuisance, first, second;
};

// Nuisance columns out of `candidates`; what of each rival does not follow from them.
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
  const auto& [a, b] = *options.between;
  const Model others = without_rivals(known, *options.between);
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
  Choice choice = choose(W, base_preference(body_count, arm_count), of_a, of_b);
  if (choice.first.empty() || choice.second.empty()) {
    // The bodies' own parameters can take the rival's place; it shows only where they are known.
    question.bodies_known = true;
    choice = choose(W, numbers(body_count, arm_count - body_count), of_a, of_b);
  }
  for (const auto& [rival, columns] : {std::make_pair(a, choice.first), {b, choice.second}}) {
    require(!columns.empty(), "excitation: '", label(rival),
            "' cannot be told from what the model has already, whatever the motion.");
  }
  const auto beyond = [&](const std::vector<int>& own, const std::vector<int>& other) {
    std::vector<int> rest = choice.nuisance;
    rest.insert(rest.end(), other.begin(), other.end());
    return !independent_columns(W, own, rest).empty();
  };
  const bool first_shows = beyond(choice.first, choice.second);
  const bool second_shows = beyond(choice.second, choice.first);
  require(first_shows || second_shows, "excitation: '", label(a), "' and '", label(b),
          "' cannot be told apart, whatever the motion: they have the same columns.");
  std::vector<int> taken = choice.nuisance;
  taken.insert(taken.end(), choice.first.begin(), choice.first.end());
  taken.insert(taken.end(), choice.second.begin(), choice.second.end());
  for (const RivalCause& rival : {a, b}) {
    const bool on_joint = rival.effect == "torque_gain" || has_effect(rival.effect);
    if (on_joint) question.rival_joints.push_back(find_joint(arm, rival));
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
