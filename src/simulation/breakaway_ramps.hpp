#pragma once

#include <vector>

#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// A time at which a joint was at rest, was pushed more and more, and gave way.
struct Ramp {
  Eigen::Index rest;   ///< the first row
  Eigen::Index onset;  ///< the row at which it began to slide
  Eigen::Index end;    ///< the row after the last one before the next jump of the position
};

/// What counts as having left a rest, as sliding, and as having rested.
struct RampThresholds {
  double way;    ///< [rad], [m]
  double speed;  ///< [rad/s], [m/s]
  double rest;   ///< [s]
};

/// The ramps of a joint: rests that end in sliding. A jump of the position (a new start) ends a
/// ramp; a leap of the effort begins a new one. Ramps start low: rests whose effort was above 60 %
/// of that at the onset are pauses. Rests pushed against an end of the range are none.
std::vector<Ramp> find_ramps(const Coordinate& joint, const VectorXd& time, const VectorXd& q,
                             const VectorXd& tau, const RampThresholds& limit);

}  // namespace veridyn
