#include "veridyn/control/model_error_observer.hpp"

#include <cassert>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn {

ModelErrorObserver::ModelErrorObserver(int joints, const ModelErrorOptions& options)
    : options_(options), d_(VectorXd::Zero(joints)), y_(d_), dq_(d_), lacking_(d_) {
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
  first_ = true;
}

bool ModelErrorObserver::set_limit(const VectorXd& limit) noexcept {
  if (limit.size() != d_.size() || !limit.allFinite() || limit.minCoeff() < 0.0) return false;
  options_.limit = limit;
  return true;
}

const VectorXd& ModelErrorObserver::update(const ArmState& arm, const VectorXd& y,
                                           double dt) noexcept {
  assert(y.size() == d_.size() && arm.joints() == d_.size());
  if (!first_) {
    lacking_ = y_ * dt - (arm.dq() - dq_);
    d_.noalias() += options_.bandwidth * arm.mass_matrix().lazyProduct(lacking_);
    d_ = d_.cwiseMin(options_.limit).cwiseMax(-options_.limit);
  }
  first_ = false;
  y_ = y;
  dq_ = arm.dq();
  return d_;
}

}  // namespace veridyn
