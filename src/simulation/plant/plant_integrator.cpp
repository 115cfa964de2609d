#include <algorithm>
#include <cmath>
#include <utility>

#include "simulation/plant/plant_state.hpp"
#include "simulation/plant/small_cholesky.hpp"

namespace veridyn {
namespace {

// Velocity, relative to that at the substep's start, that counts as zero.
constexpr double kLanded = 1e-7;
constexpr double kStill = 1e-12;     // [rad/s] or [m/s] speed that counts as rest
constexpr int kMostLocations = 40;   // largest number of iterations that locate a zero velocity
// Largest number of iterations for forces that depend on the load while the load depends on them.
constexpr int kMostLoadRounds = 60;
constexpr double kLoadConverged = 1e-13;

}  // namespace

void Plant::State::add_biases(Instant& at) {
  at.bias = at.h;
  forces.add_smooth(at.time, at.q.data(), at.dq.data(), at.bias.data());
}

// Evaluates the terms of an instant; false if the mass matrix is not positive definite.
bool Plant::State::evaluate(Instant& at) {
  rigid.equation_of_motion(at.q, at.dq, at.M, at.h);
  add_biases(at);
  return factor(at);
}

bool Plant::State::factor(Instant& at) {
  const double* rotors = forces.inertia().data();
  const double* bodies = at.M.data();
  double* L = at.L.data();
  for (int k = 0; k < n * n; ++k) L[k] = bodies[k] + rotors[k];
  return cholesky_in_place(L, n);
}

// Evaluates the stage in the middle of a substep, which two slopes share.
bool Plant::State::evaluate_middle() {
  rigid.equation_of_motion(stage.q, stage.dq, stage.M, stage.h, slopes);
  add_biases(stage);
  return factor(stage);
}

// Changes the middle stage from the velocity of its first slope to that of the second, at the same
// position. The two differ by O(h^2), so that the derivative of h suffices for order four.
void Plant::State::change_middle_velocity(double h) {
  for (int i = 0; i < n; ++i) white[i] = here.dq[i] + 0.5 * h * k2[i] - stage.dq[i];
  for (int j = 0; j < n; ++j) add_scaled(white[j], slopes.data() + j * n, n, stage.h.data());
  stage.dq += white;
  add_biases(stage);
}

void Plant::State::accelerate(Instant& at, const VectorRef& tau, Friction friction, VectorXd& ddq) {
  if (forces.loads() > 0) sticking.save_directions();
  for (int round = 0; round < kMostLoadRounds; ++round) {
    if (forces.loads() > 0) sticking.restore_directions();
    for (int i = 0; i < n; ++i) white[i] = tau[i] - at.bias[i];
    for (int k = 0; k < forces.dry(); ++k) {
      const int direction = sticking.direction(k);
      if (direction == 0) continue;
      const double v = forces.velocity(k, at.dq.data());
      add_scaled(-forces.sliding(k, at.time, at.q.data(), v, direction), forces.axis(k), n,
                 white.data());
    }
    if (friction == Friction::kDecide) {
      sticking.resolve_friction(forces, at.L.data(), at.time, at.q.data(), white.data());
    } else {
      solve_lower(at.L.data(), n, white.data());
      sticking.hold(at.L.data(), white.data());
    }
    ddq = white;
    solve_lower_transposed(at.L.data(), n, ddq.data());
    if (forces.loads() == 0) return;
    torques = at.h;
    for (int j = 0; j < n; ++j) add_scaled(ddq[j], at.M.data() + j * n, n, torques.data());
    const double change = forces.set_loads(torques.data());
    add_biases(at);
    if (!(change > kLoadConverged * (1.0 + torques.cwiseAbs().maxCoeff()))) return;
  }
}

// Computes the acceleration at the start of a substep, and which axes slide.
void Plant::State::begin(const VectorRef& tau) {
  for (int k = 0; k < forces.dry(); ++k) {
    const double v = forces.velocity(k, here.dq.data());
    sticking.set_direction(k, std::abs(v) <= kStill ? 0 : v > 0.0 ? 1 : -1);
  }
  accelerate(here, tau, Friction::kDecide, here.ddq);
}

// Advances by h with Nystroem's method, whose two middle slopes have the same position and share its mass
// matrix. False if the mass matrix becomes singular.
bool Plant::State::nystroem(const VectorRef& tau, double h) {
  stage.time = here.time + 0.5 * h;
  stage.q = here.q + 0.5 * h * here.dq + 0.125 * h * h * here.ddq;
  stage.dq = here.dq + 0.5 * h * here.ddq;
  if (!evaluate_middle()) return false;
  accelerate(stage, tau, Friction::kKeep, k2);
  change_middle_velocity(h);
  accelerate(stage, tau, Friction::kKeep, k3);
  there.time = here.time + h;
  there.q = here.q + h * here.dq + (h * h / 6.0) * (here.ddq + k2 + k3);
  return last_stage(tau, h);
}

// Computes the last slope and the velocity at the end in a single evaluation. The end position is
// known before the last slope and differs from the stage by O(h^3), so first order there is order
// four. The end velocity differs by O(h^3) from that of the stage, at the usual tolerance by less
// than 1e-5 of itself, see error(): to first order the velocity torques are correct to 1e-10.
bool Plant::State::last_stage(const VectorRef& tau, double h) {
  way = (h * h / 6.0) * (2.0 * k3 - here.ddq - k2);
  stage.time = there.time;
  stage.q = there.q + way;
  stage.dq = here.dq + h * k3;
  rigid.equation_of_motion(there.q, stage.dq, k3, way, there.M, there.h, slopes, push);
  if (!factor(there)) return false;
  stage.M = there.M;
  stage.L = there.L;
  stage.h = there.h + push;
  add_biases(stage);
  accelerate(stage, tau, Friction::kKeep, k4);
  there.dq = here.dq + (h / 6.0) * (here.ddq + 2.0 * (k2 + k3) + k4);
  for (int j = 0; j < n; ++j)
    add_scaled(there.dq[j] - stage.dq[j], slopes.data() + j * n, n, there.h.data());
  return true;
}

// The estimated error divided by the allowed error, the worst of all joints; requires nystroem().
double Plant::State::error(const VectorRef& tau, double h) {
  accelerate(there, tau, Friction::kKeep, there.ddq);
  double worst = 0.0;
  for (int i = 0; i < n; ++i) {
    const double speed = std::max(std::abs(here.dq[i]), std::abs(there.dq[i]));
    const double of_dq = h * std::abs(k4[i] - there.ddq[i]);
    const double of_q = std::abs(here.dq[i] + h * k3[i] - there.dq[i]);
    const double ratio =
        0.1 * h * std::max(of_dq, of_q) / (options.tolerance * (speed * h + options.rest));
    if (ratio <= worst) continue;  // the comparison is false for NaN, which is kept
    worst = ratio;
    failed = {i};
  }
  return worst;
}

double Plant::State::velocity(int axis, const VectorXd& dq) const {
  return axis < forces.dry() ? forces.velocity(axis, dq.data())
                             : forces.memory_velocity(axis - forces.dry(), dq.data());
}

// The sign of an axis' velocity during the substep; 0: any.
int Plant::State::velocity_sign(int axis) const {
  if (axis < forces.dry()) return sticking.direction(axis);
  const double v = velocity(axis, here.dq);
  return std::abs(v) <= kStill ? 0 : v > 0.0 ? 1 : -1;
}

double Plant::State::time_to_rest(int axis) const {
  return kLanded * std::abs(velocity(axis, here.dq)) + kStill;
}

// The index of the axis that reverses first during the substep, or -1.
int Plant::State::first_reversal() const {
  int first = -1;
  double least = 2.0;
  for (int axis = 0; axis < forces.dry() + forces.memories(); ++axis) {
    const int sign = velocity_sign(axis);
    const double after = sign * velocity(axis, there.dq);
    if (sign == 0 || !(after < -time_to_rest(axis))) continue;
    const double before = std::max(0.0, sign * velocity(axis, here.dq));
    const double share = before / (before - after);
    if (share >= least) continue;
    least = share;
    first = axis;
  }
  return first;
}

// Shortens h until no axis reverses within the substep, so that the first one comes to rest at its end. Uses
// the Illinois method, since velocities are nearly linear over a substep.
bool Plant::State::locate(const VectorRef& tau, double* h) {
  for (int axis = first_reversal(); axis >= 0; axis = first_reversal()) {
    const int sign = velocity_sign(axis);
    double low = 0.0;
    double high = *h;
    double v_low = std::max(0.0, sign * velocity(axis, here.dq));
    double v_high = sign * velocity(axis, there.dq);
    int last = 0;
    for (int tries = 0; tries < kMostLocations; ++tries) {
      const bool straight = v_low > 0.0;
      *h = straight ? (low * v_high - high * v_low) / (v_high - v_low) : 0.5 * (low + high);
      if (!nystroem(tau, *h)) return false;
      const double v = sign * velocity(axis, there.dq);
      if (!(std::abs(v) > time_to_rest(axis))) break;
      const int which = v > 0.0 ? 1 : -1;
      if (which > 0) {
        low = *h;
        v_low = v;
        if (last > 0) v_high *= 0.5;
      } else {
        high = *h;
        v_high = v;
        if (last < 0) v_low *= 0.5;
      }
      last = which;
    }
    if (sign * velocity(axis, there.dq) < -time_to_rest(axis)) return true;  // closest approach
  }
  return true;
}

// Takes one substep of at most *h and commits it; sets *h to its length.
StepStatus Plant::State::substep(const VectorRef& tau, double* h, double smallest) {
  const double asked = *h;
  for (;;) {
    bool sound = nystroem(tau, *h) && locate(tau, h);
    const bool finite = there.q.allFinite() && there.dq.allFinite();
    sound = sound && finite;
    if (sound) add_biases(there);
    const double ratio = sound ? error(tau, *h) : 1e4;
    if (ratio <= 1.0) {
      const double factor = ratio < 2e-3 ? 4.0 : std::min(4.0, 0.9 / std::pow(ratio, 0.25));
      // A substep that was shortened for other reasons does not limit the next one.
      next_h = *h < asked ? std::max(asked, factor * *h) : factor * *h;
      commit();
      return StepStatus::kOk;
    }
    ++work.refused;
    if (*h <= smallest) return step_failure(finite, sound);
    *h *= std::max(0.1, 0.9 / std::pow(ratio, 0.25));
    if (!std::isfinite(*h)) *h = smallest;
  }
}

StepStatus Plant::State::step_failure(bool finite, bool sound) {
  if (!finite) {
    failed = first_not_finite(there.q);
    if (!failed) failed = first_not_finite(there.dq);
    return StepStatus::kNotFinite;
  }
  if (sound) return StepStatus::kTooStiff;
  failed.reset();
  return StepStatus::kNotPositive;
}

void Plant::State::commit() {
  ++work.taken;
  bool turned = false;
  for (int k = 0; k < forces.dry(); ++k) {
    const int sign = sticking.direction(k);
    if (sign == 0 || sign * velocity(k, there.dq) > time_to_rest(k)) continue;
    sticking.set_direction(k, 0);
    turned = true;
  }
  std::swap(here, there);
  sticking.stop_resting_axes(here.dq.data());
  if (turned) evaluate(here);
  forces.commit(here.time, here.q.data(), here.dq.data());
}

void Plant::State::add_up_effects() {
  effects = here.bias - here.h;
  for (int j = 0; j < n; ++j)
    add_scaled(here.ddq[j], forces.inertia().data() + j * n, n, effects.data());
  for (int k = 0; k < forces.dry(); ++k) {
    const double v = forces.velocity(k, here.dq.data());
    const double force =
        sticking.was_at_rest(k) ? sticking.force(k)
                            : forces.sliding(k, here.time, here.q.data(), v, sticking.direction(k));
    add_scaled(force, forces.axis(k), n, effects.data());
  }
}

}  // namespace veridyn
