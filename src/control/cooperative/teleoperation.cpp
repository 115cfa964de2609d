#include "veridyn/control/teleoperation.hpp"

#include <algorithm>
#include <cmath>

#include "math/rotation.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {

using Eigen::Vector3d;

Teleoperation::Teleoperation(const TeleoperationOptions& options, const Vector3d& leader,
                             const Vector3d& follower)
    : options_(options), leader_start_(leader), follower_start_(follower) {
  for (const double value : {options.scale, options.largest_force, options.speed, options.cutoff,
                             options.ramp, options.period}) {
    require(std::isfinite(value) && value > 0.0, "teleoperation: found ", value,
            " among its options, expected numbers above zero.");
  }
  for (const double value : {options.force_scale, options.damping}) {
    require(std::isfinite(value) && value >= 0.0, "teleoperation: found ", value,
            " among its options, expected numbers not below zero.");
  }
  require(leader.allFinite() && follower.allFinite(), "teleoperation: found tips without a place.");
  require(is_rotation(options.R_follower_leader, 1e-6), "teleoperation: found an R_follower_leader that "
          "is no rotation.");
  share_ = 1.0 - std::exp(-2.0 * M_PI * options.cutoff * options.period);
  target_.position = target_.motion = follower;
}

void Teleoperation::update(const Vector3d& leader, const Vector3d& velocity,
                           const Vector3d& force) noexcept {
  if (!leader.allFinite() || !velocity.allFinite() || !force.allFinite()) wanted_in_ = false;
  if (wanted_in_ != in_) {
    in_ = wanted_in_;
    since_ = 0.0;
    leader_start_ = leader;
    follower_start_ = target_.position;
  }
  since_ += options_.period;
  target_.velocity.setZero();
  back_.setZero();
  if (!in_) {
    filtered_.setZero();
    return;
  }
  const Eigen::Matrix3d& R = options_.R_follower_leader;
  const Vector3d wanted = follower_start_ + options_.scale * (R * (leader - leader_start_));
  Vector3d step = wanted - target_.position;
  const double most = options_.speed * options_.period;
  const double size = step.norm();
  if (size > most) {
    step *= most / size;
    target_.velocity = step / options_.period;
  } else {
    const Vector3d ahead = options_.scale * (R * velocity);
    target_.velocity = ahead * std::min(1.0, options_.speed / std::max(ahead.norm(), options_.speed));
  }
  target_.position += step;
  target_.motion = target_.position;
  filtered_ += share_ * (force - filtered_);
  Vector3d felt = -options_.force_scale * (R.transpose() * filtered_);
  felt *= std::min(1.0, since_ / options_.ramp) *
          std::min(1.0, options_.largest_force / std::max(felt.norm(), options_.largest_force));
  back_ = felt - options_.damping * velocity;
}

}  // namespace veridyn
