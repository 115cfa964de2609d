#pragma once

#include <functional>

#include "rest_points.hpp"
#include "veridyn/cooperation/stability.hpp"

namespace veridyn {

/// Largest modulus of the eigenvalues per cycle of the loop at a point of rest. A law with a
/// deadband acts with any share of its integral gain: the worst of several shares counts.
double loop_radius(const LinearPoint& point, const Scenario& scenario,
                   const LoopSettings& settings = {});

/// Beyond this modulus per cycle the loop swings: the rounding of eigenvalues.
constexpr double kUnstable = 1.0 + 1e-9;

/// Where f changes from stable (at most kUnstable) to not, from `begin` upwards to `end` by equal
/// ratios, then halved; `end` where it does not.
double first_crossing(const std::function<double(double)>& radius, double begin, double end,
                      int steps);

/// Whether the loop is stable while every reading lags by any phase from zero to this one [rad].
bool stable_up_to_phase(const LinearPoint& point, const Scenario& scenario, double phase);

/// Largest amplification over frequency from a torque that is missing, M^-1/2 w, to M^1/2 ddq.
double torque_error_gain(const LinearPoint& point, const Scenario& scenario, int frequencies);

StabilityMargins loop_margins(const LinearPoint& point, const Scenario& scenario);

/// A law of increments in member `index`, iterated in the linear loop from the force wanted at its
/// point of rest down to none.
DeadbandSwing deadband_swing(const LinearPoint& point, const Scenario& scenario, int index);

}  // namespace veridyn
