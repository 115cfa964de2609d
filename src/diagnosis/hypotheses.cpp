#include "hypotheses.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "veridyn/effects/effect.hpp"

namespace veridyn {
namespace {

// Lengths and speeds to try, as shares of a joint's travel and of its largest speed.
constexpr std::array<double, 7> kLengthShares = {3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.25};
constexpr std::array<double, 3> kGapShares = {1e-3, 5e-3, 2e-2};
constexpr std::array<double, 3> kSpeedShares = {0.02, 0.06, 0.2};
constexpr std::array<double, 2> kExponents = {0.4, 0.7};

struct Motion {
  double travel = 0.0;
  double middle = 0.0;
  double speed = 0.0;
  double duration = 0.0;
};

Motion motion_along(const Axis& axis, const std::vector<CompressedRecording>& facts) {
  Motion m;
  for (const CompressedRecording& r : facts) {
    double middle = axis.offset;
    double travel = 0.0;
    double speed = 0.0;
    for (Eigen::Index i = 0; i < axis.coefficients.size(); ++i) {
      const TorqueFacts& joint = r.joints[static_cast<size_t>(i)];
      const double c = axis.coefficients[i];
      middle += c * 0.5 * (joint.lowest + joint.highest);
      travel += std::abs(c) * joint.travel();
      speed += std::abs(c) * joint.largest_speed;
    }
    if (travel > m.travel) m.middle = middle;
    m.travel = std::max(m.travel, travel);
    m.speed = std::max(m.speed, speed);
    m.duration = std::max(m.duration, r.facts.duration);
  }
  return m;
}

int stage_of(const std::string& effect) {
  if (effect == "torque_gain" || effect == "time_delay" || effect == "torque_drift" ||
      effect == "torque_offset")
    return 0;
  if (effect == "rotor_inertia" || effect == "joint_spring" || effect == "transmission_compliance")
    return 1;
  return 2;
}

bool has_term(const Model& arm, const std::string& effect, const Axis& axis) {
  for (const EffectTerm& term : arm.effects()) {
    if (term.effect == effect && term.axis.coefficients == axis.coefficients) return true;
  }
  return false;
}

class Builder {
 public:
  Builder(const Model& arm, const std::vector<CompressedRecording>& facts,
          const std::vector<std::string>& wanted)
      : arm_(arm), facts_(facts), wanted_(wanted), description_(arm.description()) {}

  void ask_all() {
    for (const Axis& axis : axes()) {
      const Motion m = motion_along(axis, facts_);
      for (const Effect* effect : all_effects()) ask(*effect, axis, m);
    }
  }

  AugmentedModel take() {
    AugmentedModel out{Model(std::move(description_)), std::move(hypotheses_)};
    const std::vector<StandardParameter> parameters = standard_parameters(out.model);
    for (Hypothesis& h : out.hypotheses) {
      for (const StandardParameter& p : parameters) {
        if (p.effect == h.term) h.columns.push_back(p.name);
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
    return out;
  }

  void ask(const Effect& effect, const Axis& axis, const Motion& m) {
    const std::string name = effect.name();
    if (!wanted_.empty() && std::find(wanted_.begin(), wanted_.end(), name) == wanted_.end())
      return;
    const bool plain = (axis.coefficients.array() != 0.0).count() == 1;
    if (!plain && name != "presliding_hysteresis") return;
    if (has_term(arm_, name, axis) && !effect.has_memory()) return;
    if (name == "torque_ripple") return;  // its order comes from a spectrum, not from a grid
    const auto add = [&](const char* key, double value) { this->add(name, axis, {{key, value}}); };
    if (name == "presliding_hysteresis") {
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
           int from = -1) {
    EffectTerm term;
    term.effect = effect;
    term.axis = axis;
    term.values = shape;
    if (from >= 0) term.from = Axis{VectorXd::Unit(arm_.joints(), from), 0.0};
    Hypothesis h;
    h.effect = effect;
    h.joint = main_coordinate(axis);
    h.term = static_cast<int>(description_.effects.size());
    h.stage = stage_of(effect);
    h.family = effect + " " + axis_text(arm_, axis) +
               (from >= 0 ? " from " + arm_.coordinates()[from].name : "");
    for (const EffectParameter& p : find_effect(effect).parameters()) h.signs.push_back(p.sign);
    description_.effects.push_back(std::move(term));
    hypotheses_.push_back(std::move(h));
  }

  const Model& arm_;
  const std::vector<CompressedRecording>& facts_;
  const std::vector<std::string>& wanted_;
  ModelDescription description_;
  std::vector<Hypothesis> hypotheses_;
};

}  // namespace

AugmentedModel augmented_model(const Model& arm, const std::vector<CompressedRecording>& facts,
                               const std::vector<std::string>& wanted) {
  Builder builder(arm, facts, wanted);
  builder.ask_all();
  return builder.take();
}

}  // namespace veridyn
