#include "veridyn/control/force_law.hpp"

#include <algorithm>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kCarried = 1.4;        // [kg] mass at the member for which its damping is designed
constexpr double kMostDamping = 120.0;  // [N s/m] largest damping
constexpr double kCrossover = 30.0;     // [rad/s] crossover frequency of the force loop
constexpr double kReachForce = 20.0;    // [N] force error that the largest displacement (ForceLaw::reach) can correct

}  // namespace

ForceLaw tuned_force_law(double member_stiffness, double follower_stiffness, double follower_damping) {
  require(member_stiffness > 0.0 && follower_stiffness > 0.0 && follower_damping >= 0.0,
          "tuned force law: found stiffnesses of ", member_stiffness, " and ", follower_stiffness,
          " N/m, expected numbers above zero.");
  const double damping = std::min(kMostDamping, 2.0 * std::sqrt(kCarried * member_stiffness));
  ForceLaw law;
  law.stiffness = member_stiffness;
  law.gain = kCrossover / follower_stiffness;
  law.proportional = law.gain * (damping + follower_damping) / member_stiffness;
  law.damping = damping / follower_stiffness;
  law.feed_forward = 1.0 / follower_stiffness;
  law.reach = kReachForce * (1.0 / follower_stiffness + 1.0 / member_stiffness);
  return law;
}

ForceTracker::ForceTracker(const ForceLaw& law) : law_(law) {
  for (const double value : {law.deadband, law.increment, law.gain, law.proportional, law.damping,
                             law.feed_forward, law.reach, law.stiffness}) {
    require(std::isfinite(value) && value >= 0.0, "force law: found ", value,
            ", expected numbers that are finite and not below zero.");
  }
}

void ForceTracker::reset() noexcept {
  x_f_ = value_ = velocity_ = 0.0;
  number_.reset();
}

double ForceTracker::update(double wanted, const ForceReading& reading, double rate,
                            double dt) noexcept {
  if (!std::isfinite(dt)) return value_;
  clock_ += dt;
  const double e = wanted - reading.force;
  if (reading.number && reading.number != number_) {
    // The time of a lost sample is part of the next interval.
    const double since = !number_ ? dt : clock_ - last_time_;
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
  const bool answers = number_ && law_.kind == ForceLaw::Kind::kProportional;
  return limited(wanted, rate, answers ? law_.proportional * e : 0.0);
}

double ForceTracker::update_without_sensor(double wanted, double rate) noexcept {
  velocity_ = 0.0;
  return limited(wanted, rate, 0.0);
}

double ForceTracker::limited(double wanted, double rate, double proportional) noexcept {
  const double sum = x_f_ + law_.feed_forward * wanted - law_.damping * rate + proportional;
  if (std::isfinite(sum)) value_ = std::clamp(sum, -law_.reach, law_.reach);
  return value_;
}

}  // namespace veridyn
