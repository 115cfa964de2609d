#include "simulation/plant/plant_forces.hpp"

#include <algorithm>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn {

bool is_dry_friction(const Effect& effect, const ShapeValues& shape) {
  const std::string name = effect.name();
  if (name == "coulomb_friction") return shape[0] == 0.0;             // no slope: a true sign
  if (name == "load_dependent_friction") return shape[0] == 0.0;      // no distance: no memory
  if (name == "position_dependent_friction") return shape[1] == 0.0;  // likewise
  return name == "stribeck_friction" || name == "asymmetric_friction" ||
         name == "sublinear_viscous" || name == "warm_up";
}

bool describes_measured_motion(const EffectTerm& term) {
  return term.effect == "transmission_compliance";
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
    sum += row[static_cast<size_t>(p)] * term.values[static_cast<size_t>(p)];
  }
  return sum;
}

// True if the force is constant + s s + ds ds + dds dds at all times. Asked, not listed: at slow
// and fast, near and far samples.
bool PlantForces::fold(const Term& term, double* constant, double* s, double* ds, double* dds) {
  const Effect& effect = *term.effect;
  if (effect.has_memory() || effect.needs_load() || effect.needs_source()) return false;
  const auto at = [&](double time, double s_, double ds_, double dds_) {
    EffectState none{};
    AxisSample x;
    x.time = time;
    x.s = s_;
    x.ds = ds_;
    x.dds = dds_;
    return force(term, x, none);
  };
  *constant = at(0, 0, 0, 0);
  *s = at(0, 1, 0, 0) - *constant;
  *ds = at(0, 0, 1, 0) - *constant;
  *dds = at(0, 0, 0, 1) - *constant;
  const double size = std::abs(*constant) + std::abs(*s) + std::abs(*ds) + std::abs(*dds);
  for (const double scale : {-1e-5, 3e-4, 0.07, -0.9, 13.0}) {
    for (int direction = 0; direction < 4; ++direction) {
      const double x = direction == 0 || direction == 3 ? scale : 0.0;
      const double v = direction == 1 || direction == 3 ? scale : 0.0;
      const double a = direction == 2 || direction == 3 ? scale : 0.0;
      const double expected = *constant + *s * x + *ds * v + *dds * a;
      const double allowed = 1e-12 * size * std::max(1.0, std::abs(scale));
      if (!(std::abs(at(0.0, x, v, a) - expected) <= allowed)) return false;
      if (!(std::abs(at(40.0, x, v, a) - expected) <= allowed)) return false;
    }
  }
  return true;
}

PlantForces::Term PlantForces::bound(const Model& arm, const EffectTerm& of) {
  const BoundEffect effect(arm, of);
  require(effect.has_values(), "plant: effect '", of.effect, "' on ", axis_text(arm, of.axis),
          " has no values.");
  Term term{&effect.effect(),
            effect.parameter_count(),
            effect.shape(),
            effect.values(),
            line_of(of.axis),
            {},
            of.axis.offset,
            0.0,
            -1,
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
  for (const EffectTerm& of : arm.effects()) {
    Term term = bound(arm, of);
    if (describes_measured_motion(of)) {
      left_out_.push_back("transmission_compliance on " + axis_text(arm, of.axis) +
                          ": it describes measured motion; a forward simulation needs the motor as "
                          "a body of its own");
      continue;
    }
    double constant = 0.0, s = 0.0, ds = 0.0, dds = 0.0;
    if (fold(term, &constant, &s, &ds, &dds)) {
      add_affine(of, constant, s, ds, dds);
      continue;
    }
    if (term.effect->needs_load()) {
      term.load = loads();
      loads_.push_back({of.axis.coefficients / of.axis.coefficients.squaredNorm()});
    }
    if (is_dry_friction(*term.effect, term.shape)) {
      add_dry(of, term);
      continue;
    }
    if (term.effect->has_memory()) memories_.push_back(term.axis);
    smooth_.push_back(std::move(term));
  }
}

void PlantForces::add_affine(const EffectTerm& of, double constant, double s, double ds,
                             double dds) {
  const VectorXd& c = of.axis.coefficients;
  inertia_ += dds * c * c.transpose();
  damping_ += ds * c * c.transpose();
  stiffness_ += s * c * c.transpose();
  constant_ += (constant + s * of.axis.offset) * c;
  has_damping_ = has_damping_ || ds != 0.0;
  has_stiffness_ = has_stiffness_ || s != 0.0;
}

void PlantForces::add_dry(const EffectTerm& of, const Term& term) {
  auto at = std::find_if(dry_.begin(), dry_.end(),
                         [&](const Dry& d) { return d.direction == of.axis.coefficients; });
  if (at == dry_.end()) {
    dry_.push_back({of.axis.coefficients, term.axis, {}, 0.0});
    at = dry_.end() - 1;
  }
  if (of.effect == "coulomb_friction") {
    at->constant += term.values[0];
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
  if (term.load >= 0) x.load = loads_[static_cast<size_t>(term.load)].value;
  return x;
}

void PlantForces::reset(const double* q, const double* dq) {
  for (Load& load : loads_) load.value = 0.0;
  for (Term& term : smooth_) term.state = {};
  commit(0.0, q, dq);
}

void PlantForces::commit(double time, const double* q, const double* dq) {
  for (Term& term : smooth_) {
    if (term.effect->has_memory()) force(term, sample(term, time, q, dq), term.state);
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
  const Dry& dry = dry_[static_cast<size_t>(k)];
  double sum = direction * dry.constant;
  for (const Term& term : dry.terms) {
    AxisSample x;
    x.time = time;
    x.s = term.offset + along(term.axis, q);
    x.ds = direction * std::max(direction * velocity, kRestSpeed);
    if (term.load >= 0) x.load = loads_[static_cast<size_t>(term.load)].value;
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
  // A level below zero (a polynomial beyond its range) holds nothing.
  if (lower > upper) return {0.5 * (lower + upper), 0.5 * (lower + upper)};
  return {lower, upper};
}

}  // namespace veridyn
