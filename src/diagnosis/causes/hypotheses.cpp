#include "diagnosis/causes/hypotheses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "veridyn/effects/effect.hpp"
#include "veridyn/identification/arm_effects.hpp"

namespace veridyn {
namespace {

// Lengths and speeds to try, as shares of a joint's travel and of its largest speed.
constexpr std::array<double, 7> kLengthShares = {3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.25};
constexpr std::array<double, 3> kGapShares = {1e-3, 5e-3, 2e-2};
constexpr std::array<double, 3> kSpeedShares = {0.02, 0.06, 0.2};
constexpr std::array<double, 2> kExponents = {0.4, 0.7};

constexpr double kRippleOrders = 600.0;   // waves per travel that a spectrum looks at
constexpr double kStillRevolute = 5e-3;   // [rad] of travel
constexpr double kStillPrismatic = 5e-4;  // [m]

struct Motion {
  double travel = 0.0;
  double middle = 0.0;
  double speed = 0.0;
  double duration = 0.0;
};

// Over all recordings together: their ranges may differ.
Motion motion_along(const Axis& axis, const std::vector<CompressedRecording>& facts) {
  Motion m;
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

int stage_of(const std::string& effect) {
  if (is_arm_effect(effect) || effect == "torque_drift" || effect == "torque_offset" ||
      effect == "payload")
    return 0;
  if (effect == "rotor_inertia" || effect == "joint_spring" || effect == "transmission_compliance")
    return 1;
  return 2;
}

// Effects whose torque is a function of positions; a single motion ties all positions together.
bool depends_on_place(const std::string& effect) {
  static const std::set<std::string> kNames = {
      "joint_spring", "position_force", "position_dependent_friction",  "torque_ripple",
      "gravity_tilt", "cable_coupling", "position_dependent_viscosity", "encoder_offset",
      "torque_drift", "warm_up"};
  return kNames.count(effect) != 0;
}

// Columns of these are derivatives: a value beyond is outside of what they describe, and no fault
// of this kind is so large without being noticed.
double largest_value(const std::string& effect, bool slides) {
  if (effect == "torque_gain") return 0.6;
  if (effect == "time_delay") return 0.02;                     // [s]
  if (effect == "encoder_offset") return slides ? 0.03 : 0.2;  // [m], [rad]
  if (effect == "gravity_tilt") return 0.3;                    // [rad]
  return 1e300;
}

// Index of the arm's own term, or -1.
int own_term(const Model& arm, const std::string& effect, const Axis& axis) {
  for (size_t k = 0; k < arm.effects().size(); ++k) {
    const EffectTerm& term = arm.effects()[k];
    if (term.effect == effect && term.axis.coefficients == axis.coefficients)
      return static_cast<int>(k);
  }
  return -1;
}

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
      h.term = static_cast<int>(description_.effects.size());
      h.columns.clear();
      asked_.insert(key(term));
      description_.effects.push_back(term);
      hypotheses_.push_back(std::move(h));
    }
    // Friction holds a joint at rest against anything: its torque says nothing about the arm.
    int moving = 0;
    for (int i = 0; i < arm_.joints(); ++i) moving += static_cast<int>(moves(i));
    const bool whole_arm = 2 * moving >= arm_.joints();
    if (whole_arm && wanted("gravity_tilt"))
      add("gravity_tilt", {VectorXd::Zero(arm_.joints()), 0.0}, {});
    for (const Axis& axis : axes()) {
      const Motion m = motion_along(axis, facts_);
      if (!moves(main_coordinate(axis))) continue;
      for (const Effect* effect : all_effects()) ask(*effect, axis, m);
      const bool plain = (axis.coefficients.array() != 0.0).count() == 1;
      for (const char* effect : {"torque_gain", "time_delay", "encoder_offset"}) {
        if (plain && wanted(effect)) add(effect, axis, {});
      }
    }
    if (whole_arm && list_.changes && wanted("payload")) {
      for (const int frame : payload_frames(arm_)) add_payload(frame);
    }
  }

  AugmentedModel take() {
    AugmentedModel out{Model(std::move(description_)), std::move(hypotheses_)};
    const std::vector<StandardParameter> parameters = standard_parameters(out.model);
    for (Hypothesis& h : out.hypotheses) {
      for (const StandardParameter& p : parameters) {
        if (h.term >= 0 ? p.effect == h.term : p.body == h.body) h.columns.push_back(p.name);
      }
    }
    return out;
  }

 private:
  // Every coordinate, and every other axis on which the model has friction already.
  std::vector<Axis> axes() const {
    std::vector<Axis> out;
    for (int i = 0; i < arm_.joints(); ++i) out.push_back({VectorXd::Unit(arm_.joints(), i), 0.0});
    for (const EffectTerm& term : arm_.effects()) {
      const bool known = std::any_of(out.begin(), out.end(), [&term](const Axis& a) {
        return (a.coefficients - term.axis.coefficients).norm() < 1e-9 ||
               std::abs(a.coefficients.normalized().dot(term.axis.coefficients.normalized())) >
                   1.0 - 1e-9;
      });
      if (!known && term.effect == "coulomb_friction") out.push_back(term.axis);
    }
    // Joint variables that are mixtures of coordinates.
    for (const Frame& frame : arm_.frames()) {
      const VectorXd& c = frame.variable.coefficients;
      if (frame.type == JointType::kFixed || c.isZero(0.0)) continue;
      const bool known = std::any_of(out.begin(), out.end(), [&c](const Axis& a) {
        return std::abs(a.coefficients.normalized().dot(c.normalized())) > 1.0 - 1e-9;
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
        arm_.coordinates()[static_cast<size_t>(joint)].prismatic ? kStillPrismatic : kStillRevolute;
    return std::any_of(facts_.begin(), facts_.end(), [&](const CompressedRecording& r) {
      return r.joints[static_cast<size_t>(joint)].travel() > still;
    });
  }

  bool wanted(const std::string& name) const {
    const std::vector<std::string>& some = list_.wanted;
    return some.empty() || std::find(some.begin(), some.end(), name) != some.end();
  }

  void ask(const Effect& effect, const Axis& axis, const Motion& m) {
    const std::string name = effect.name();
    if (!wanted(name)) return;
    const bool plain = (axis.coefficients.array() != 0.0).count() == 1;
    if (!plain && name != "presliding_hysteresis" && name != "position_force" &&
        name != "coulomb_friction" && name != "viscous_friction")
      return;
    const bool has_shapes = !effect.shapes().empty();
    const int own = own_term(arm_, name, axis);
    if (own >= 0 && list_.changes && !effect.needs_source()) {
      add(name, axis, arm_.effects()[static_cast<size_t>(own)].values, -1, own);
      if (!has_shapes) return;
    }
    if (own >= 0 && !list_.changes && !effect.has_memory()) return;
    const auto add = [&](const char* key, double value) { this->add(name, axis, {{key, value}}); };
    if (name == "torque_ripple") {
      const auto joint = static_cast<size_t>(main_coordinate(axis));
      if (joint >= list_.ripple_orders.size()) return;
      for (const double order : list_.ripple_orders[joint]) add("order", order);
    } else if (name == "presliding_hysteresis") {
      for (const double share : kLengthShares) add("distance", share * m.travel);
    } else if (name == "backlash") {
      for (const double share : kGapShares) add("gap", share * m.travel);
    } else if (name == "stribeck_friction") {
      for (const double share : kSpeedShares) add("velocity", share * m.speed);
    } else if (name == "sublinear_viscous") {
      for (const double exponent : kExponents) add("exponent", exponent);
    } else if (name == "warm_up") {
      add("time_constant", std::max(5.0, 0.5 * m.duration));
    } else if (name == "position_dependent_friction" || name == "position_dependent_viscosity") {
      add("centre", m.middle);
    } else if (name == "position_force") {
      this->add(name, axis, {{"centre", m.middle}, {"half_range", 0.5 * m.travel}});
    } else if (effect.needs_source()) {
      for (int from = 0; from < arm_.joints(); ++from) {
        if (axis.coefficients[from] == 0.0) this->add(name, axis, {}, from);
      }
    } else {
      this->add(name, axis, {});
    }
  }

  void add(const std::string& effect, const Axis& axis, const std::map<std::string, double>& shape,
           int from = -1, int changes = -1) {
    EffectTerm term;
    term.effect = effect;
    term.axis = axis;
    term.values = shape;
    const std::vector<EffectParameter> parameters =
        is_arm_effect(effect) ? arm_effect_parameters(effect) : find_effect(effect).parameters();
    for (const EffectParameter& p : parameters) term.values.erase(p.name);
    if (from >= 0) term.from = Axis{VectorXd::Unit(arm_.joints(), from), 0.0};
    if (!asked_.insert(key(term)).second) return;
    Hypothesis h;
    h.effect = effect;
    h.joint = effect == "gravity_tilt" ? -1 : main_coordinate(axis);
    h.changes = changes;
    h.term = static_cast<int>(description_.effects.size());
    h.stage = stage_of(effect);
    h.extrapolates = depends_on_place(effect);
    if (effect == "torque_ripple") h.tried = kRippleOrders;
    h.largest_value = largest_value(effect, is_prismatic(arm_, axis));
    h.family = (changes >= 0 ? "changed " : "") + effect + " " + axis_text(arm_, axis) +
               (from >= 0 ? " from " + arm_.coordinates()[from].name : "");
    for (const EffectParameter& p : parameters)
      h.signs.push_back(changes >= 0 ? ParameterSign::kAny : p.sign);
    for (const EffectParameter& p : parameters) {
      if (changes < 0) break;
      const auto& own = arm_.effects()[static_cast<size_t>(changes)].values;
      const auto value = own.find(p.name);
      h.lowest.push_back(p.sign == ParameterSign::kAny || value == own.end() ? -1e300
                                                                             : -value->second);
    }
    description_.effects.push_back(std::move(term));
    hypotheses_.push_back(std::move(h));
  }

  // One body more on the link, without mass as long as nobody fits it.
  void add_payload(int frame) {
    Frame load;
    load.name = "payload@" + arm_.frames()[static_cast<size_t>(frame)].name;
    load.parent = frame;
    load.variable.coefficients = VectorXd::Zero(arm_.joints());
    load.body = Body{};
    load.body->phi = InertialParameters::Zero();
    Hypothesis h;
    h.effect = "payload";
    h.frame = frame;
    for (int i = 0; i < arm_.joints(); ++i) {
      if (arm_.moves(frame, i)) h.joint = i;
    }
    h.body = static_cast<int>(arm_.bodies().size()) + payloads_++;
    h.stage = stage_of("payload");
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
