#include "simulation/plant/plant_forces.hpp"

#include <algorithm>

#include "veridyn/math/require.hpp"
#include "veridyn/effects/effect_facts.hpp"

namespace veridyn {

bool describes_measured_motion(const EffectTerm& term) {
  return !find_axis_effect(term.effect).traits().forward_simulable;
}

PlantForces::Line PlantForces::line_of(const Axis& axis) {
  Line line;
  for (Eigen::Index i = 0; i < axis.coefficients.size(); ++i) {
    const double c = axis.coefficients[i];
    if (c != 0.0) line.push_back({static_cast<int>(i), c});
  }
  return line;
}

double PlantForces::force(const Term& term, const AxisSample& x, EffectState& state) {
  EffectColumns row;
  term.effect->columns(x, term.shape, state, row);
  double sum = 0.0;
  for (int p = 0; p < term.parameters; ++p) {
    sum += row[p] * term.values[p];
  }
  return sum;
}

// The coefficients of an affine force: constant + s s + ds ds + dds dds.
PlantForces::Affine PlantForces::affine(const Term& term) {
  const auto at = [&term](double s, double ds, double dds) {
    EffectState none{};
    AxisSample x;
    x.s = s;
    x.ds = ds;
    x.dds = dds;
    return force(term, x, none);
  };
  const double constant = at(0, 0, 0);
  return {constant, at(1, 0, 0) - constant, at(0, 1, 0) - constant, at(0, 0, 1) - constant};
}

PlantForces::Term PlantForces::bound(const Model& arm, const EffectTerm& of) {
  const EffectFacts effect(arm, of);
  require(effect.has_values(), "plant: effect '", of.effect, "' on ", axis_text(arm, of.axis),
          " has no values.");
  Term term{&effect.effect(),
            effect.traits(),
            effect.parameter_count(),
            effect.shape(),
            effect.values(),
            line_of(of.axis),
            {},
            of.axis.offset,
            0.0,
            {},
            {}};
  if (of.from) {
    term.from = line_of(*of.from);
    term.from_offset = of.from->offset;
  }
  return term;
}

PlantForces::PlantForces(const Model& arm)
    : n_(arm.joints()),
      inertia_(MatrixXd::Zero(n_, n_)),
      damping_(inertia_),
      stiffness_(inertia_),
      constant_(VectorXd::Zero(n_)) {
  for (const EffectTerm& of : arm.arm_effects()) {
    const EffectTraits traits = find_effect(of.effect).traits();
    left_out_.push_back(of.effect + " on the arm: " +
                        (traits.forward_simulable ? "it has states of its own, see make_engine()"
                                                  : traits.not_simulable_because));
  }
  for (const EffectTerm& of : arm.effects()) {
    Term term = bound(arm, of);
    if (!term.traits.forward_simulable) {
      left_out_.push_back(of.effect + " on " + axis_text(arm, of.axis) + ": " +
                          term.traits.not_simulable_because);
      continue;
    }
    const bool nothing = !term.traits.memory && is_zero(term);
    if (term.traits.affine || nothing) {
      add_affine(of, affine(term));
      continue;
    }
    if (term.traits.uses_load) {
      term.load = loads();
      loads_.push_back({of.axis.coefficients / of.axis.coefficients.squaredNorm()});
    }
    if (term.traits.dry != DryFriction::kNone) {
      add_dry(of, term);
      continue;
    }
    if (term.traits.memory) memories_.push_back(term.axis);
    smooth_.push_back(std::move(term));
  }
}

bool PlantForces::is_zero(const Term& term) {
  return std::all_of(term.values.begin(), term.values.begin() + term.parameters,
                     [](double value) { return value == 0.0; });
}

void PlantForces::add_affine(const EffectTerm& of, const Affine& f) {
  const VectorXd& c = of.axis.coefficients;
  inertia_ += f.dds * c * c.transpose();
  damping_ += f.ds * c * c.transpose();
  stiffness_ += f.s * c * c.transpose();
  constant_ += (f.constant + f.s * of.axis.offset) * c;
  has_damping_ = has_damping_ || f.ds != 0.0;
  has_stiffness_ = has_stiffness_ || f.s != 0.0;
}

void PlantForces::add_dry(const EffectTerm& of, const Term& term) {
  auto at = std::find_if(dry_.begin(), dry_.end(),
                         [&](const Dry& d) { return d.direction == of.axis.coefficients; });
  if (at == dry_.end()) {
    dry_.push_back({of.axis.coefficients, term.axis, {}, 0.0});
    at = dry_.end() - 1;
  }
  if (term.traits.dry == DryFriction::kConstant) {
    AxisSample sliding;
    sliding.ds = kRestSpeed;
    EffectState none{};
    at->constant += force(term, sliding, none);
  } else {
    at->terms.push_back(term);
  }
}

AxisSample PlantForces::sample(const Term& term, double time, const double* q,
                               const double* dq) const {
  AxisSample x;
  x.time = time;
  x.s = term.offset + along(term.axis, q);
  x.ds = along(term.axis, dq);
  if (!term.from.empty()) {
    x.from_s = term.from_offset + along(term.from, q);
    x.from_ds = along(term.from, dq);
  }
  if (term.load) x.load = loads_[*term.load].value;
  return x;
}

void PlantForces::reset(const double* q, const double* dq) {
  for (Load& load : loads_) load.value = 0.0;
  for (Term& term : smooth_) term.state = {};
  commit(0.0, q, dq);
}

void PlantForces::commit(double time, const double* q, const double* dq) {
  for (Term& term : smooth_) {
    if (term.traits.memory) force(term, sample(term, time, q, dq), term.state);
  }
}

void PlantForces::add_smooth(double time, const double* q, const double* dq, double* sum) const {
  const auto n = static_cast<size_t>(n_);
  for (size_t i = 0; i < n; ++i) sum[i] += constant_.data()[i];
  for (size_t j = 0; j < n && (has_damping_ || has_stiffness_); ++j) {
    const double* D = damping_.data() + j * n;
    const double* K = stiffness_.data() + j * n;
    for (size_t i = 0; i < n; ++i) sum[i] += D[i] * dq[j] + K[i] * q[j];
  }
  for (const Term& term : smooth_) {
    EffectState trial = term.state;
    const double f = force(term, sample(term, time, q, dq), trial);
    for (const Entry& e : term.axis) sum[e.coordinate] += e.coefficient * f;
  }
}

double PlantForces::set_loads(const double* rigid_torques) {
  double change = 0.0;
  for (Load& load : loads_) {
    double effort = 0.0;
    for (int i = 0; i < n_; ++i) effort += load.axis[i] * rigid_torques[i];
    change = std::max(change, std::abs(effort - load.value));
    load.value = effort;
  }
  return change;
}

double PlantForces::sliding(int k, double time, const double* q, double velocity,
                            int direction) const {
  const Dry& dry = dry_[k];
  double sum = direction * dry.constant;
  for (const Term& term : dry.terms) {
    AxisSample x;
    x.time = time;
    x.s = term.offset + along(term.axis, q);
    x.ds = direction * std::max(direction * velocity, kRestSpeed);
    if (term.load) x.load = loads_[*term.load].value;
    EffectState none{};
    sum += force(term, x, none);
  }
  return sum;
}

double PlantForces::friction_power(const VectorXd& q, int i, double speed) const {
  VectorXd still = VectorXd::Zero(n_);
  VectorXd at_rest_force = still;
  add_smooth(0.0, q.data(), still.data(), at_rest_force.data());
  double least = 0.0;
  double size = 0.0;
  for (const int side : {-1, 1}) {
    VectorXd dq = VectorXd::Zero(n_);
    dq[i] = side * speed;
    VectorXd moving = still;
    add_smooth(0.0, q.data(), dq.data(), moving.data());
    double power = dq.dot(moving - at_rest_force);
    size = std::max(size, speed * (std::abs(moving[i]) + std::abs(at_rest_force[i])));
    for (int k = 0; k < dry(); ++k) {
      const double v = velocity(k, dq.data());
      if (v != 0.0) power += v * sliding(k, 0.0, q.data(), v, v > 0.0 ? 1 : -1);
    }
    least = std::min(least, power);
  }
  return least < -1e-12 * size ? least : 0.0;
}

Interval PlantForces::at_rest(int k, double time, const double* q) const {
  const double upper = sliding(k, time, q, 0.0, 1);
  const double lower = sliding(k, time, q, 0.0, -1);
  // A negative level (a polynomial outside of its range) cannot hold an axis.
  if (lower > upper) return {0.5 * (lower + upper), 0.5 * (lower + upper)};
  return {lower, upper};
}

}  // namespace veridyn
