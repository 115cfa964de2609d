#include "veridyn/control/adaptive_friction.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn {

AdaptiveFriction::AdaptiveFriction(const FrictionCompensation& friction,
                                   const AdaptiveFrictionOptions& options)
    : options_(options),
      scale_(static_cast<size_t>(friction.axes()), 1.0),
      offset_(scale_.size(), 0.0) {
  require(options.least >= 0.0 && options.least <= 1.0 && options.most >= 1.0 &&
              options.most <= 2.0 && options.rate >= 0.0 && std::isfinite(options.rate),
          "AdaptiveFriction: found bounds of ", options.least, " and ", options.most,
          " and a rate of ", options.rate,
          ", expected bounds from 0 to 2 with 1 between them and a rate that is not below zero.");
}

void AdaptiveFriction::update(const ArmState& arm, const VectorXd& lacking, double dt,
                              FrictionCompensation& friction) noexcept {
  assert(lacking.size() == arm.joints());
  if (!options_.enabled || !(dt > 0.0) || !lacking.allFinite()) return;
  for (int k = 0; k < friction.axes(); ++k) {
    const VectorXd& c = friction.axis(k);
    const double v = c.dot(arm.dq());
    const double least_speed =
        friction.prismatic(k) ? options_.velocity.prismatic : options_.velocity.revolute;
    if (!(std::abs(v) > least_speed)) continue;
    const auto at = static_cast<size_t>(k);
    const double direction = v < 0.0 ? -1.0 : 1.0;
    const double force = friction.sliding(k, direction, v);  // signed by the direction
    if (std::abs(force) < 1e-9) continue;
    // Friction that the compensation, with its present share and scale, does not cover.
    const double along = c.dot(lacking) / c.squaredNorm();
    const double found = along + friction.share() * friction.scale(k) * force;
    const double wrong = found - offset_[at] - scale_[at] * force;
    const double step = std::min(0.5, options_.rate * dt);
    offset_[at] += step * wrong;
    scale_[at] = std::clamp(scale_[at] + step * wrong / force, options_.least, options_.most);
    friction.set_scale(k, scale_[at]);
  }
}

}  // namespace veridyn
