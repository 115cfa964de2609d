#include "veridyn/control/adaptive_friction.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kExcited = 0.2;  // smallest share of the sum of F^2 that remains after a fit of offset and slope
constexpr double kNoFriction = 1e-9;  // [N m], [N] smaller friction counts as none
constexpr double kNoPlace = 1e-9;  // relative variation of the position, below which no slope is determined

}  // namespace

AdaptiveFriction::AdaptiveFriction(const FrictionCompensation& friction,
                                   const AdaptiveFrictionOptions& options)
    : options_(options), axes_(static_cast<size_t>(friction.axes())) {
  for (Learned& axis : axes_) axis.share = friction.share();
  require(options.least >= 0.0 && options.least <= friction.share() &&
              options.most >= friction.share() && options.most <= 2.0 && options.rate >= 0.0 &&
              std::isfinite(options.rate),
          "AdaptiveFriction: found bounds of ", options.least, " and ", options.most,
          " and a rate of ", options.rate, ", expected bounds from 0 to 2 with the share of ",
          friction.share(), " between them and a rate that is not below zero.");
}

void AdaptiveFriction::adapt(Learned& axis, double force, double s, double needed,
                             double dt) const noexcept {
  if (axis.first) axis.place = s;
  axis.first = false;
  const double step = std::min(0.5, options_.rate * dt);
  const Eigen::Vector3d row(force, 1.0, s - axis.place);
  axis.information += step * (row * row.transpose() - axis.information);
  axis.right += step * (needed * row - axis.right);
  // Remainders of F and y after regression on 1 and s.
  const Eigen::Matrix3d& J = axis.information;
  const double spread = J(2, 2) - J(1, 2) * J(1, 2) / J(1, 1);
  const double slope =
      spread > kNoPlace * J(2, 2) ? (J(0, 2) - J(0, 1) * J(1, 2) / J(1, 1)) / spread : 0.0;
  const double offset = (J(0, 1) - slope * J(1, 2)) / J(1, 1);
  const double alone = J(0, 0) - offset * J(0, 1) - slope * J(0, 2);
  if (!(alone > kExcited * J(0, 0))) return;
  const double found = (axis.right[0] - offset * axis.right[1] - slope * axis.right[2]) / alone;
  axis.share += step * (std::clamp(found, options_.least, options_.most) - axis.share);
}

void AdaptiveFriction::update(const ArmState& arm, const VectorRef& missing, double dt,
                              FrictionCompensation& friction) noexcept {
  assert(missing.size() == arm.joints());
  if (!options_.enabled || !(dt > 0.0) || !missing.allFinite() || !(friction.share() > 0.0)) return;
  if (!arm.q().allFinite() || !arm.dq().allFinite()) return;
  for (int k = 0; k < friction.axes(); ++k) {
    const VectorXd& c = friction.axis(k);
    Learned& axis = axes_[k];
    // Mean velocity over the cycle to which `missing` belongs. With the velocity at its end, cycles would be
    // chosen in which noise lifts it above the deadband, and their acceleration would appear too large.
    const double v = 0.5 * (axis.speed + c.dot(arm.dq()));
    const double applied = axis.applied;
    axis.speed = c.dot(arm.dq());
    axis.applied = friction.force(k);
    const double least_speed =
        friction.prismatic(k) ? options_.velocity.prismatic : options_.velocity.revolute;
    if (!(std::abs(v) > least_speed)) continue;
    const double force =
        friction.sliding(k, v < 0.0 ? -1.0 : 1.0, v);  // its sign is that of the direction
    if (std::abs(force) < kNoFriction) continue;
    const double needed = c.dot(missing) / c.squaredNorm() + applied;
    adapt(axis, force, c.dot(arm.q()), needed, dt);
    friction.set_scale(k, axis.share / friction.share());
  }
}

}  // namespace veridyn
