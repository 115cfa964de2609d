#include "veridyn/control/momentum_observer.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

#include "control/static_forces.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

FrictionOptions full_friction_options() {
  FrictionOptions options;
  options.rule = FrictionRule::kMeasured;
  options.share = 1.0;
  options.tank_capacity.revolute = options.tank_capacity.prismatic = std::numeric_limits<double>::infinity();
  return options;
}

// For each coordinate the first frame with a body that it moves; the number of frames if there is none.
std::vector<int> first_frames(const Model& arm) {
  std::vector<int> first(arm.joints(), static_cast<int>(arm.frames().size()));
  for (int i = 0; i < arm.joints(); ++i) {
    for (const auto [k] : arm.bodies()) {
      if (!arm.moves({k}, {i})) continue;
      first[i] = k;
      break;
    }
  }
  return first;
}

}  // namespace

MomentumObserver::MomentumObserver(const Model& arm, const Tip& tip,
                                   const MomentumObserverOptions& options)
    : options_(options),
      dynamics_(arm, control_parameters(arm, "MomentumObserver")),
      friction_(arm, full_friction_options()),
      uncertainty_(arm, options.uncertainty),
      inverse_(arm, tip, TaskRows::kPosition, options.inverse),
      frames_(first_frames(arm)),
      order_(static_cast<size_t>(arm.joints())),
      r_(VectorXd::Zero(arm.joints())),
      gradient_(r_),
      threshold_(r_),
      sum_(r_),
      p_(r_),
      p_start_(r_),
      none_(r_),
      above_(static_cast<size_t>(arm.joints()), 0) {
  require(options.bandwidth > 0.0 && std::isfinite(options.bandwidth) && options.cycles > 0,
          "MomentumObserver: found a bandwidth of ", options.bandwidth, " 1/s and ", options.cycles,
          " cycles, expected both above zero.");
  std::iota(order_.begin(), order_.end(), 0);
  std::stable_sort(order_.begin(), order_.end(), [this](int a, int b) {
    return frames_[a] > frames_[b];
  });
  for (int& frame : frames_) {
    if (frame == static_cast<int>(arm.frames().size())) frame = -1;
  }
}

void MomentumObserver::reset() noexcept {
  first_ = true;
  coordinate_.reset();
  r_.setZero();
  threshold_.setZero();
  wrench_.setZero();
  std::fill(above_.begin(), above_.end(), 0);
}

const VectorXd& MomentumObserver::update(const ArmState& arm, const VectorRef& tau_motor,
                                         const VectorRef& ddq, double dt) noexcept {
  assert(arm.joints() == r_.size() && tau_motor.size() == r_.size() && ddq.size() == r_.size());
  if (!arm.q().allFinite() || !arm.dq().allFinite() || !tau_motor.allFinite() || !ddq.allFinite() ||
      !(dt >= 0.0) || !std::isfinite(dt)) {
    reset();
    return r_;
  }
  p_.noalias() = arm.mass_matrix().lazyProduct(arm.dq());
  // The residual r decays with the observer's bandwidth, and so must the threshold.
  const double falls = std::exp(-options_.bandwidth * dt);
  const VectorXd& now = uncertainty_.update(arm, ddq);
  threshold_ = now.cwiseMax(now + falls * (threshold_ - now));
  const VectorXd& friction = friction_.update(arm, none_, none_, dt);
  if (first_) {
    first_ = false;
    p_start_ = p_;
    sum_.setZero();
    r_.setZero();
    return r_;
  }
  dynamics_.lagrangian_gradient(arm.q(), arm.dq(), gradient_);
  // The bias contains the torques of effects in addition to C dq + g.
  sum_ += dt * (tau_motor - friction - (arm.bias() - arm.rigid_bias()) + gradient_ - r_);
  r_ = options_.bandwidth * (sum_ - p_ + p_start_);
  inverse_.update(arm.tip().jacobian());
  inverse_.solve_wrench(r_, wrench_);
  coordinate_.reset();
  for (const int i : order_) {
    int& count = above_[i];
    count = std::abs(r_[i]) > threshold_[i] ? std::min(count + 1, options_.cycles) : 0;
    if (!coordinate_ && count >= options_.cycles) coordinate_ = i;
  }
  return r_;
}

}  // namespace veridyn
