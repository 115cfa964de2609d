#include "veridyn/simulation/plant.hpp"

#include <algorithm>
#include <cassert>

#include "simulation/plant/plant_state.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// Smallest substep as a share of the whole step; a state that needs smaller ones is too stiff.
constexpr double kSmallestStep = 1e-6;

}  // namespace

Plant::Plant(const Model& arm, const PlantOptions& options) {
  require(options.tolerance > 0.0 && options.rest > 0.0 && options.most_substeps > 0,
          "plant: found a tolerance, a rest or a number of substeps that is not above zero.");
  const auto phi = arm.inertial_values();
  require(phi.has_value(), "plant: the arm '", arm.name(), "' has bodies without values.");
  state_ = std::make_unique<State>(arm, *phi, options);
  const std::string trouble = infeasibility(arm);
  require(trouble.empty(), "plant: ", trouble);
  const VectorXd zero = VectorXd::Zero(arm.joints());
  set_state(zero, zero);
}

Plant::~Plant() = default;
Plant::Plant(Plant&&) noexcept = default;
Plant& Plant::operator=(Plant&&) noexcept = default;

int Plant::joints() const {
  return state_->n;
}
double Plant::time() const {
  return state_->here.time;
}
const VectorXd& Plant::q() const {
  return state_->here.q;
}
const VectorXd& Plant::dq() const {
  return state_->here.dq;
}
std::optional<JointIndex> Plant::failed_joint() const {
  return state_->failed;
}
const VectorXd& Plant::effect_torques() const {
  return state_->effects;
}
Plant::Work Plant::work() const {
  return state_->work;
}
const std::vector<std::string>& Plant::left_out() const {
  return state_->forces.left_out();
}

void Plant::set_state(const VectorRef& q, const VectorRef& dq) {
  State& s = *state_;
  require(q.size() == s.n && dq.size() == s.n, "plant: found a state of ", q.size(), " and ",
          dq.size(), " entries, expected ", s.n, ".");
  require(q.allFinite() && dq.allFinite(), "plant: found a state that is not finite.");
  s.here.time = 0.0;
  s.here.q = q;
  s.here.dq = dq;
  s.next_h = 0.0;
  s.failed.reset();
  s.work = {};
  s.sticking.reset();
  s.forces.reset(s.here.q.data(), s.here.dq.data());
  require(s.evaluate(s.here), "plant: the mass matrix is not positive definite at the start.");
}

StepStatus Plant::accelerate(const VectorRef& tau, VectorXd& ddq) noexcept {
  State& s = *state_;
  assert(tau.size() == s.n && ddq.size() == s.n);
  s.failed = first_not_finite(tau);
  if (s.failed) return StepStatus::kNotFinite;
  s.begin(tau);
  ddq = s.here.ddq;
  s.add_up_effects();
  return StepStatus::kOk;
}

StepStatus Plant::step(const VectorRef& tau, double dt) noexcept {
  State& s = *state_;
  assert(tau.size() == s.n && dt > 0.0);
  s.failed = first_not_finite(tau);
  if (s.failed) return StepStatus::kNotFinite;
  const double end = s.here.time + dt;
  if (!(s.next_h > 0.0)) s.next_h = dt;
  double left = dt;
  for (int k = 0; left > 0.0; ++k) {
    if (k == s.options.most_substeps) return StepStatus::kTooStiff;
    s.begin(tau);
    // The last two substeps are equal, which avoids a tiny last one.
    double h = s.next_h >= left ? left : std::min(s.next_h, 0.5 * left);
    const StepStatus status = s.substep(tau, &h, kSmallestStep * dt);
    if (status != StepStatus::kOk) return status;
    left = left - h > 1e-12 * dt ? left - h : 0.0;
  }
  s.here.time = end;
  s.failed.reset();
  return StepStatus::kOk;
}

}  // namespace veridyn
