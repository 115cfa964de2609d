#pragma once

#include <functional>

#include "rest_points.hpp"
#include "veridyn/cooperation/stability.hpp"

namespace veridyn {

/// Largest modulus of the eigenvalues per cycle of the loop at an equilibrium. A law with a
/// deadband acts with any share of its integral gain: the worst of several shares is returned.
double loop_radius(const LinearPoint& point, const Scenario& scenario,
                   const LoopSettings& settings = {});

/// Modulus per cycle above which the loop is unstable: one, plus the rounding of eigenvalues.
constexpr double kUnstable = 1.0 + 1e-9;

/// [N/m] ends of the search over stiffnesses.
constexpr double kSoftest = 1.0, kStiffest = 1e7;

/// Value at which `radius` changes from stable (at most kUnstable) to unstable, searched from `begin` to
/// `end` by equal ratios, then by bisection; `end` if there is none.
double first_crossing(const std::function<double(double)>& radius, double begin, double end,
                      int steps);

/// True if the loop is stable for phase lags of the readings up to this one [rad], in steps of 5 degrees or less.
bool stable_up_to_phase(const LinearPoint& point, const Scenario& scenario, double phase);

/// Upper bound of the amplification from a missing torque, M^-1/2 w, to M^1/2 ddq, on a grid of frequencies.
double torque_error_gain(const LinearPoint& point, const Scenario& scenario, int frequencies);

/// Margins of gain, phase and delay; all 0 if the loop is unstable, infinite without elements.
StabilityMargins loop_margins(const LinearPoint& point, const Scenario& scenario);

/// Simulates an incremental law of member `index` in the linear loop, from zero force to that of
/// its equilibrium.
DeadbandSwing deadband_swing(const LinearPoint& point, const Scenario& scenario, int index);

}  // namespace veridyn
