#include "veridyn/control/model_error_observer.hpp"

#include <cassert>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// Relative difference between requested and sent torque that counts as rounding.
constexpr double kSentShare = 1e-9;

}  // namespace

ModelErrorObserver::ModelErrorObserver(int joints, const ModelErrorOptions& options)
    : options_(options),
      d_(VectorXd::Zero(joints)),
      y_(d_),
      dq_(d_),
      lacking_(d_),
      step_(d_),
      not_sent_(d_),
      missing_(d_) {
  require(options.limit.size() == joints && options.limit.allFinite() &&
              options.limit.minCoeff() >= 0.0,
          "ModelErrorObserver: found limits that are not ", joints,
          " finite numbers, none below zero.");
  require(options.bandwidth > 0.0 && std::isfinite(options.bandwidth),
          "ModelErrorObserver: found a bandwidth of ", options.bandwidth,
          " 1/s, expected one above zero.");
}

void ModelErrorObserver::reset() noexcept {
  d_.setZero();
  not_sent_.setZero();
  missing_.setZero();
  first_ = true;
}

void ModelErrorObserver::set_sent_torques(const VectorRef& asked, const VectorRef& sent) noexcept {
  assert(asked.size() == d_.size() && sent.size() == d_.size());
  const double least = kSentShare * asked.cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < d_.size(); ++i) {
    const double missing = asked[i] - sent[i];
    const bool counts = std::abs(missing) > least;
    not_sent_[i] = std::isfinite(missing) && counts ? missing : 0.0;
  }
}

bool ModelErrorObserver::set_limit(const VectorRef& limit) noexcept {
  if (limit.size() != d_.size() || !limit.allFinite() || limit.minCoeff() < 0.0) return false;
  options_.limit = limit;
  return true;
}

const VectorXd& ModelErrorObserver::update(const ArmState& arm, const VectorRef& y,
                                           double dt) noexcept {
  assert(y.size() == d_.size() && arm.joints() == d_.size());
  if (!arm.q().allFinite() || !arm.dq().allFinite() || !y.allFinite() || !(dt >= 0.0) ||
      !std::isfinite(dt)) {
    first_ = true;  // d is kept, but no change of velocity is computed across the gap
    return d_;
  }
  if (!first_) {
    lacking_ = y_ * dt - (arm.dq() - dq_);
    step_.noalias() = arm.mass_matrix().lazyProduct(lacking_);
    step_ -= dt * not_sent_;
    missing_ = d_;
    if (dt > 0.0) missing_ += step_ / dt;
    step_ *= options_.bandwidth;
    for (Eigen::Index i = 0; i < d_.size(); ++i) {
      if (step_[i] * not_sent_[i] <= 0.0) d_[i] += step_[i];
    }
    d_ = d_.cwiseMin(options_.limit).cwiseMax(-options_.limit);
  }
  first_ = false;
  not_sent_.setZero();
  y_ = y;
  dq_ = arm.dq();
  return d_;
}

}  // namespace veridyn
