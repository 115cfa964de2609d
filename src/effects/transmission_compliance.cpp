#include <algorithm>
#include <cmath>

#include "effects/described_effect.hpp"
#include "registry.hpp"

namespace veridyn {
namespace {

// Indices into the state: 1 denotes the previous sample, 2 the one before it.
enum : size_t { kCount, kTime1, kLoad1, kTime2, kLoad2, kResult };

}  // namespace

/// An elastic transmission, to first order in its compliance:
///
///   tau = compliance_inertia * d^2 load / dt^2
///
/// Positive where the position is measured on the link: the rotor (inertia J) turns ahead by load /
/// K and must be accelerated, J / K. Negative where it is measured on the motor: the link (inertia
/// M) lags by load / K, - M / K. 1 / sqrt(|compliance_inertia|) is the resonance [rad/s] with the
/// other side held; the motion must stay well below. Source: Spong, J. Dyn. Sys. Meas. Control
/// 109(4), 1987, reduced to first order in 1/K.
///
/// The second derivative is the divided difference of the last three samples, so it lags by one time step; it
/// is zero for the first two. The effect describes measured motion. In a forward simulation the feedback
/// through the load is unstable; that would need the motor as a body of its own.
const Effect& transmission_compliance() {
  EffectTraits t;
  t.uses_load = true;
  t.memory = true;
  t.lasting = true;
  t.forward_simulable = false;
  t.not_simulable_because =
      "it describes measured motion; a forward simulation needs the motor as a body of its own";
  static const DescribedEffect kEffect({"transmission_compliance", {{"compliance_inertia", "s^2", "s^2"}}, {}, t,
      [](const AxisSample& x, const ShapeValues&, EffectState& state, EffectColumns& row) noexcept {
        const double dt = x.time - state[kTime1];
        if (state[kCount] == 0.0 || dt > 0.0) {
          if (state[kCount] == 2.0) {
            const double slope_now = (x.load - state[kLoad1]) / dt;
            const double slope_before =
                (state[kLoad1] - state[kLoad2]) / (state[kTime1] - state[kTime2]);
            state[kResult] = 2.0 * (slope_now - slope_before) / (x.time - state[kTime2]);
          }
          state[kTime2] = state[kTime1];
          state[kLoad2] = state[kLoad1];
          state[kTime1] = x.time;
          state[kLoad1] = x.load;
          state[kCount] = std::min(2.0, state[kCount] + 1.0);
        }
        row[0] = state[kResult];
      },
      nullptr,
      [](const Effect&, const std::vector<double>& values, const ShapeValues&, JointType) {
        if (values[0] == 0.0) return std::string("a rigid transmission");
        return "an elastic transmission: a resonance near " + text_with_unit(0.5 / (M_PI * std::sqrt(std::abs(values[0]))), "Hz") +
               (values[0] > 0.0 ? ", measured on the link" : ", measured on the motor");
      }});
  return kEffect;
}

}  // namespace veridyn
