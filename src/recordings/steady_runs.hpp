#pragma once

#include <cstddef>
#include <vector>

namespace veridyn {

/// A stretch of a joint's motion during which its speed stays within a tenth of its mean for half a
/// second or longer.
struct SteadyRun {
  std::size_t from = 0, end = 0;  ///< samples from .. end - 1
  double velocity = 0.0;          ///< mean [rad/s], [m/s]
};

/// The stretches of one joint, none overlapping another. Speeds below a hundredth of the largest one
/// count as rest; a gap in time ends a stretch.
/// @param time  [s], growing. @param dq  as many speeds.
std::vector<SteadyRun> steady_runs(const std::vector<double>& time, const std::vector<double>& dq);

/// True where two speeds differ by less than a tenth.
bool same_speed(double a, double b);

/// True where a joint travels far enough for its friction to show: 20 mrad or 2 mm. A joint that is
/// held gives by less while its neighbours accelerate.
bool travels(double from, double to, bool prismatic);

/// The place at which such a joint is held, to 10 mrad or 1 mm: a hair's breadth of tilt would be one
/// more parameter that no motion tells.
double held_at(double position, bool prismatic);

}  // namespace veridyn
