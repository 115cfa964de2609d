#include "veridyn/control/force_law.hpp"

#include <algorithm>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn {

ForceTracker::ForceTracker(const ForceLaw& law) : law_(law) {
  for (const double value : {law.deadband, law.increment, law.gain, law.proportional, law.damping,
                             law.feed_forward, law.reach, law.stiffness}) {
    require(std::isfinite(value) && value >= 0.0, "force law: found ", value,
            ", expected numbers that are finite and not below zero.");
  }
}

void ForceTracker::reset() noexcept {
  x_f_ = value_ = velocity_ = 0.0;
  number_ = -1;
}

double ForceTracker::update(double wanted, const ForceReading& reading, double rate,
                            double dt) noexcept {
  clock_ += dt;
  const double e = wanted - reading.force;
  double now = 0.0;
  if (reading.number >= 0 && reading.number != number_) {
    // Time between samples, so that a lost one counts for the next.
    const double since = number_ < 0 ? dt : clock_ - last_time_;
    const double before = x_f_;
    if (std::abs(e) > law_.deadband) {
      x_f_ += law_.kind == ForceLaw::Kind::kIncrement ? std::copysign(law_.increment, e)
                                                      : law_.gain * e * since;
    }
    x_f_ = std::clamp(x_f_, -law_.reach, law_.reach);
    velocity_ = since > 0.0 ? (x_f_ - before) / since : 0.0;
    number_ = reading.number;
    last_time_ = clock_;
  }
  now = x_f_ + law_.feed_forward * wanted - law_.damping * rate;
  if (number_ >= 0 && law_.kind == ForceLaw::Kind::kProportional) now += law_.proportional * e;
  value_ = std::clamp(now, -law_.reach, law_.reach);
  return value_;
}

}  // namespace veridyn
