#pragma once

#include <cstddef>
#include <vector>

namespace veridyn {

/// A segment of a joint's motion in which its speed stays within a tenth of its mean for half a second or
/// longer.
struct SteadyRun {
  std::size_t from = 0, end = 0;  ///< samples from .. end - 1
  double velocity = 0.0;          ///< mean [rad/s], [m/s]
};

/// The segments of one joint, without overlap. Speeds below a hundredth of the largest one count as rest; a
/// gap in time ends a segment.
/// @param time  [s], increasing. @param dq  one speed for each time.
std::vector<SteadyRun> steady_runs(const std::vector<double>& time, const std::vector<double>& dq);

/// True if two speeds differ by less than a tenth.
bool same_speed(double a, double b);

/// True if a joint travels far enough for its friction to be measured: 20 mrad or 2 mm. A held
/// joint yields by less than that while its neighbours accelerate.
bool travels_far_enough(double from, double to, bool prismatic);

/// Position at which a joint that does not travel is held, rounded to 10 mrad or 1 mm: an axis
/// tilted by less would add an unidentifiable parameter.
double rounded_hold_position(double position, bool prismatic);

}  // namespace veridyn
