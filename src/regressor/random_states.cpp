#include "regressor/random_states.hpp"

#include <algorithm>

#include "math/random_numbers.hpp"
#include "kinematics/motion_limits.hpp"
#include "veridyn/effects/effect.hpp"

namespace veridyn {
namespace {

// Widens the limits to include the ranges in which effects change, since those of a joint without limits may
// lie anywhere.
void widen(const Model& arm, MotionLimits& limits) {
  for (const EffectTerm& term : arm.effects()) {
    if (!has_axis_effect(term.effect)) continue;
    const BoundEffect effect(arm, term);
    for (const ActiveRange& range : effect.effect().active_ranges(effect.shape())) {
      const Axis& axis = range.of_source ? *term.from : term.axis;
      if ((axis.coefficients.array() != 0.0).count() != 1) continue;
      Eigen::Index i = 0;
      const double c = axis.coefficients.cwiseAbs().maxCoeff(&i) * (axis.coefficients[i] < 0.0 ? -1.0 : 1.0);
      const double low = (range.low - axis.offset) / c;
      const double high = (range.high - axis.offset) / c;
      if (range.of_velocity) {
        limits.velocity[i] = std::max({limits.velocity[i], std::abs(low), std::abs(high)});
      } else {
        limits.lower[i] = std::min({limits.lower[i], low, high});
        limits.upper[i] = std::max({limits.upper[i], low, high});
      }
    }
  }
}

}  // namespace

MotionSamples random_states(const Model& arm, int count, unsigned seed,
                            const std::vector<std::string>& still) {
  RandomNumbers random(seed);
  MotionLimits limits = motion_limits(arm);
  widen(arm, limits);
  const int n = arm.joints();
  MotionSamples out{VectorXd::LinSpaced(count, 0.0, 1.0), MatrixXd(count, n), MatrixXd(count, n),
                    MatrixXd(count, n)};
  for (int k = 0; k < count; ++k) {
    for (int i = 0; i < n; ++i) {
      out.q(k, i) = random.uniform(limits.lower[i], limits.upper[i]);
      out.dq(k, i) = limits.velocity[i] * random.uniform(-1.0, 1.0);
      out.ddq(k, i) = 5.0 * limits.velocity[i] * random.uniform(-1.0, 1.0);
    }
  }
  for (int i = 0; i < n; ++i) {
    const std::string& name = arm.coordinates()[i].name;
    if (std::find(still.begin(), still.end(), name) == still.end()) continue;
    out.q.col(i).setConstant(0.5 * (limits.lower[i] + limits.upper[i]));
    out.dq.col(i).setZero();
    out.ddq.col(i).setZero();
  }
  return out;
}

int state_count(int columns, int joints) {
  return 20 + 2 * columns / joints;
}

}  // namespace veridyn
