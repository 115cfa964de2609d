#pragma once

#include "veridyn/math/motion_samples.hpp"

namespace veridyn {

/// The motion at other instants, on quintics through q, dq and ddq of the neighbouring rows, with
/// their derivatives. Before the first and after the last row the values of that row are repeated,
/// velocities and accelerations included.
/// @param times  (any number) [s], ascending.
MotionSamples motion_at(const MotionSamples& motion, const VectorRef& times);

/// The motion on a uniform grid of `rate` [Hz], from the first row on.
/// @throws InvalidInput  the rate makes fewer than two rows, or more than a quarter of the machine's memory holds.
MotionSamples resampled(const MotionSamples& motion, double rate);

}  // namespace veridyn
