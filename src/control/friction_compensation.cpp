#include "veridyn/control/friction_compensation.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "control/static_forces.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kFadesBelow = 0.1;  // share of the energy tank below which compensation fades out
constexpr double kFar = 1e3;         // [rad], [m] displacement that shears every memory fully

double deadband_of(const Deadband& deadband, bool prismatic) {
  return prismatic ? deadband.prismatic : deadband.revolute;
}

double dot_product(const std::vector<JointCoefficient>& axis, const VectorRef& x) {
  double sum = 0.0;
  for (const JointCoefficient& c : axis) sum += c.coefficient * x[c.coordinate];
  return sum;
}

// Columns times the model's values.
double force_of_term(const BoundEffect& term, const EffectColumns& row) {
  double sum = 0.0;
  for (int p = 0; p < term.parameter_count(); ++p)
    sum += row[p] * term.values()[p];
  return sum;
}

}  // namespace

FrictionCompensation::FrictionCompensation(const Model& arm, const FrictionOptions& options)
    : options_(options), tau_(VectorXd::Zero(arm.joints())) {
  for (const Deadband* d : {&options.velocity, &options.position, &options.tank_capacity})
    require(d->revolute > 0.0 && d->prismatic > 0.0,
            "FrictionCompensation: found a deadband or tank capacity that is not above zero.");
  require(options.share >= 0.0 && options.share <= 2.0, "FrictionCompensation: found a share of ",
          options.share, ", expected one between 0 and 2.");
  for (const EffectTerm& term : arm.effects()) {
    BoundEffect bound(arm, term);
    if (control_part(bound.traits()) != ControlPart::kFriction) continue;
    require(bound.has_values(), "FrictionCompensation: effect ", bound.parameter_name(0),
            " of arm '", arm.name(), "' has no value; identify it first.");
    auto known = std::find_if(axes_.begin(), axes_.end(), [&](const Axis& axis) {
      return axis.c == term.axis.coefficients && axis.offset == term.axis.offset;
    });
    if (known == axes_.end()) {
      Axis axis;
      axis.c = term.axis.coefficients;
      for (Eigen::Index i = 0; i < axis.c.size(); ++i)
        if (axis.c[i] != 0.0) axis.along.push_back({static_cast<int>(i), axis.c[i]});
      axis.offset = term.axis.offset;
      axis.squared = axis.c.squaredNorm();
      axis.prismatic = is_prismatic(arm, term.axis);
      axis.velocity_deadband = deadband_of(options.velocity, axis.prismatic);
      axis.position_deadband = deadband_of(options.position, axis.prismatic);
      axis.tank_capacity = deadband_of(options.tank_capacity, axis.prismatic);
      known = axes_.insert(axes_.end(), std::move(axis));
    }
    const EffectTraits& traits = bound.traits();
    known->loaded = known->loaded || traits.uses_load;
    known->constant = known->constant && !traits.uses_position && !traits.uses_load && !traits.memory;
    known->terms.push_back(std::move(bound));
  }
  for (Axis& axis : axes_) axis.at_rest = rest_force(axis);
  reset();
}

void FrictionCompensation::reset() noexcept {
  for (Axis& axis : axes_) {
    for (BoundEffect& term : axis.terms) term.reset();
    axis.first = true;
    axis.force = 0.0;
    axis.energy = axis.largest;
  }
}

bool FrictionCompensation::set_scale(int k, double scale) noexcept {
  if (k < 0 || k >= axes() || !(scale >= 0.0 && options_.share * scale <= 2.0)) return false;
  axes_[k].scale = scale;
  return true;
}

double FrictionCompensation::sliding(const Axis& axis, double direction, double speed) noexcept {
  AxisSample x;
  x.ds = direction * std::max(std::abs(speed), 1.001 * kRestSpeed);
  x.load = axis.load;
  double sum = 0.0;
  EffectState state{};
  EffectColumns row;
  for (const BoundEffect& term : axis.terms) {
    if (term.traits().memory) {
      state = {};
      x.s = axis.s - direction * kFar;
      term.effect().columns(x, term.shape(), state, row);
    }
    x.s = axis.s;
    term.effect().columns(x, term.shape(), state, row);
    sum += force_of_term(term, row);
  }
  return sum;
}

double FrictionCompensation::sliding(int k, double direction, double speed) const noexcept {
  return sliding(axes_[k], direction, speed);
}

double FrictionCompensation::rest_force(const Axis& axis) noexcept {
  return std::max(std::abs(sliding(axis, 1.0, 0.0)), std::abs(sliding(axis, -1.0, 0.0)));
}

double FrictionCompensation::tank_level(const Axis& axis) noexcept {
  const bool supervised = std::isfinite(axis.tank_capacity) && axis.largest > 0.0;
  return supervised ? axis.energy / axis.largest : 1.0;
}

double FrictionCompensation::tank_level(int k) const noexcept {
  return tank_level(axes_[k]);
}

double FrictionCompensation::velocity_force(const Axis& axis, double v, double v_wanted,
                                         double error) const noexcept {
  if (std::abs(v) >= axis.velocity_deadband) {
    const double direction = v < 0.0 ? -1.0 : 1.0;
    return sliding(axis, direction, std::max(std::abs(v), direction * v_wanted));
  }
  if (options_.rule == FrictionRule::kVelocity || std::abs(error) <= axis.position_deadband)
    return 0.0;
  return sliding(axis, error < 0.0 ? -1.0 : 1.0, 0.0);
}

// Force of the terms with memory by their state, plus that of the other terms as if sliding at `speed` in the
// direction of `will`, scaled by its magnitude (-1 to 1).
double FrictionCompensation::memory_force(Axis& axis, double will, double speed, double v) noexcept {
  const double direction = will < 0.0 ? -1.0 : 1.0;
  AxisSample x;
  x.s = axis.s;
  x.load = axis.load;
  double sum = 0.0;
  EffectColumns row;
  for (BoundEffect& term : axis.terms) {
    const bool memory = term.traits().memory;
    x.ds = memory ? v : direction * std::max(speed, 1.001 * kRestSpeed);
    term.columns(x, row);
    sum += (memory ? 1.0 : std::abs(will)) * force_of_term(term, row);
  }
  return sum;
}

double FrictionCompensation::total_force(Axis& axis, double v, double v_wanted,
                                   double error) const noexcept {
  if (options_.rule == FrictionRule::kMeasured)
    return memory_force(axis, std::clamp(v / axis.velocity_deadband, -1.0, 1.0), std::abs(v), v);
  if (options_.rule != FrictionRule::kPresliding) return velocity_force(axis, v, v_wanted, error);
  // Friction is full along a wanted motion, and proportional to the position error at rest within the deadband.
  const double will =
      std::clamp(v_wanted / axis.velocity_deadband + error / axis.position_deadband, -1.0, 1.0);
  return memory_force(axis, will, std::max(0.0, will < 0.0 ? -v_wanted : v_wanted), v);
}

void FrictionCompensation::supervise(Axis& axis, double v_wanted, double dt) const noexcept {
  if (!std::isfinite(axis.tank_capacity)) return;
  const double level = axis.constant ? axis.at_rest : rest_force(axis);
  axis.largest = options_.share * axis.scale * level * axis.tank_capacity;
  if (axis.first) {
    axis.energy = axis.largest;
    return;
  }
  const double wanted = options_.share * axis.scale *
                        std::abs(sliding(axis, v_wanted < 0.0 ? -1.0 : 1.0, v_wanted) * v_wanted);
  axis.energy += wanted * dt - axis.force * (axis.s - axis.before);
  // A time that is NaN empties the tank.
  axis.energy = std::isnan(axis.energy) ? 0.0 : std::clamp(axis.energy, 0.0, axis.largest);
}

void FrictionCompensation::set_axis_states(const ArmState& arm) noexcept {
  for (Axis& axis : axes_) {
    axis.s = axis.offset + dot_product(axis.along, arm.q());
    if (axis.loaded) axis.load = dot_product(axis.along, arm.rigid_bias()) / axis.squared;
  }
}

const VectorXd& FrictionCompensation::update(const ArmState& arm, const VectorRef& dq_wanted,
                                             const VectorRef& error, double dt) noexcept {
  assert(arm.joints() == tau_.size() && dq_wanted.size() == tau_.size() &&
         error.size() == tau_.size());
  tau_.setZero();
  if (!arm.q().allFinite() || !arm.dq().allFinite() || !dq_wanted.allFinite() || !error.allFinite())
    return tau_;
  set_axis_states(arm);
  for (Axis& axis : axes_) {
    const double v = dot_product(axis.along, arm.dq());
    const double v_wanted = dot_product(axis.along, dq_wanted);
    const double e = dot_product(axis.along, error);
    supervise(axis, v_wanted, dt);
    const double force = total_force(axis, v, v_wanted, e);
    axis.force = options_.share * axis.scale * std::min(1.0, tank_level(axis) / kFadesBelow) * force;
    axis.before = axis.s;
    axis.first = false;
    for (const JointCoefficient& part : axis.along) tau_[part.coordinate] += axis.force * part.coefficient;
  }
  return tau_;
}

}  // namespace veridyn
